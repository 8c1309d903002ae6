// SPDX-License-Identifier: Apache-2.0
// A host that dies, a cell that gives up waiting, a cell that loses its power: `scribe --resume` burns what an
// undisturbed run burns, by the plant's own pulse trace. `scribecell bench link` does the same at 200 moments.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <signal.h>

#include "host/formats/pulse_trace.hpp"
#include "tests/sim/host/cli/program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;
using Pulses = std::vector<trace::PulseRecord>;

constexpr int kKilled = 128 + SIGKILL;

/// A cell that outlives its hosts.
class Cell {
public:
    Cell(const fs::path& folder, const std::string& out, std::vector<std::string> more)
        : folder_(folder),
          trace_(folder / out / "pulses.trace"),
          program_("scribecell-cell", words(folder, out, more)) {
        EXPECT_TRUE(program_.wait_for_err("socket"));
    }
    /// Exit code of a host that scribes face 0.
    int scribe(std::vector<std::string> more) {
        std::vector<std::string> all{"scribe",
                                     "--face",
                                     "0",
                                     "--link",
                                     "lockstep:" + (folder_ / "socket").string(),
                                     "--journal",
                                     (folder_ / "journal.sqlite").string()};
        all.insert(all.end(), more.begin(), more.end());
        Program host("scribecell", all);
        const int code = host.wait();
        said = host.err();
        return code;
    }
    Pulses end() {
        program_.signal(SIGTERM);
        EXPECT_EQ(program_.wait(), 0) << program_.err();
        return host::read_pulse_trace(trace_).pulses;
    }
    std::string said;

private:
    static std::vector<std::string> words(const fs::path& folder, const std::string& out,
                                          const std::vector<std::string>& more) {
        // The first pulses after the dark are stronger by 12 % in the reference cell: that is the source's, not the
        // job's.
        const fs::path world = fs::path(SC_SOURCE_DIR) / "boards/sim/world/default";
        fs::copy_file(world / "workpiece.obj", folder / "workpiece.obj", fs::copy_options::overwrite_existing);
        write_file(folder / "world.toml",
                   replaced(read_file(world / "world.toml"), "first_pulse_excess = 0.12", "first_pulse_excess = 0.0"));
        std::vector<std::string> all{
            "--lockstep", (folder / "socket").string(),       "--out",   (folder / out).string(),
            "--memory",   (folder / "retained.bin").string(), "--world", (folder / "world.toml").string()};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    fs::path folder_;
    fs::path trace_;
    Program program_;
};

/// The same pulses in the same order, each where it was and as strong.
void expect_same(const Pulses& pulses, const Pulses& truth) {
    ASSERT_EQ(pulses.size(), truth.size());
    double place_um = 0.0;
    double energy = 0.0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto off = static_cast<double>(pulses[i].table_pm[k] - truth[i].table_pm[k]) * 1e-6;
            place_um = std::max(place_um, std::abs(off));
        }
        energy = std::max(energy, std::abs(static_cast<double>(pulses[i].energy_nj) / truth[i].energy_nj - 1.0));
    }
    EXPECT_LT(place_um, 3.0);
    EXPECT_LT(energy, 0.02);
}

class Resume : public testing::Test {
protected:
    void SetUp() override {
        if (!undisturbed.empty()) {
            return;
        }
        Cell cell(fresh_folder(), "cell", {});
        ASSERT_EQ(cell.scribe({}), 0) << cell.said;
        undisturbed = cell.end();
    }
    static inline Pulses undisturbed;
};

TEST_F(Resume, AHostKilledWhileItMarksGoesOnWhereItWas) {
    for (const std::string at : {"8.30", "9.43", "10.2"}) {
        Cell cell(fresh_folder(), "cell", {"--kill-host-at", at, "--gap", "3"});
        ASSERT_EQ(cell.scribe({}), kKilled) << cell.said;
        ASSERT_EQ(cell.scribe({"--resume"}), 0) << cell.said;
        EXPECT_NE(cell.said.find("an earlier host has begun"), std::string::npos);
        expect_same(cell.end(), undisturbed);
    }
}

TEST_F(Resume, ACellThatHasGivenUpWaitingGoesOnOnceItsFaultIsAcknowledged) {
    Cell cell(fresh_folder(), "cell", {"--kill-host-at", "9.43", "--gap", "11"});
    ASSERT_EQ(cell.scribe({}), kKilled) << cell.said;
    EXPECT_EQ(cell.scribe({"--resume"}), 1) << "the fault is latched";
    EXPECT_NE(cell.said.find("link_lost"), std::string::npos) << cell.said;
    ASSERT_EQ(cell.scribe({"--resume", "--reset-fault"}), 0) << cell.said;
    const std::string told = "the cell's last seconds before the fault are in ";
    const std::size_t at = cell.said.find(told);
    ASSERT_NE(at, std::string::npos) << cell.said;
    const std::string file = cell.said.substr(at + told.size(), cell.said.find('\n', at) - at - told.size());
    EXPECT_NE(read_file(file).find("link_lost"), std::string::npos) << file << " says what befell";
    expect_same(cell.end(), undisturbed);
}

TEST_F(Resume, AfterALossOfPowerThePartDecidesWhatIsUncertain) {
    const fs::path folder = fresh_folder();
    Cell dark(folder, "before", {"--power-off-at", "10.3"});
    ASSERT_EQ(dark.scribe({}), 1) << dark.said;
    const Pulses before = dark.end();
    ASSERT_GT(before.size(), 100U);
    ASSERT_LT(before.size(), undisturbed.size());
    Cell cell(folder, "after", {"--seed", "2"});
    EXPECT_EQ(cell.scribe({"--resume"}), 2) << cell.said;
    EXPECT_NE(cell.said.find("it is not certain whether this stretch is burnt"), std::string::npos) << cell.said;
    EXPECT_NE(cell.said.find("pulses "), std::string::npos) << cell.said;
    EXPECT_EQ(cell.scribe({"--resume", "--confirm-uncertain", "perhaps"}), 2) << cell.said;
    ASSERT_EQ(cell.scribe({"--resume", "--confirm-uncertain", "burnt"}), 0) << cell.said;
    const Pulses after = cell.end();
    const std::size_t all = before.size() + after.size();
    EXPECT_LE(all, undisturbed.size()) << "no pulse twice";
    EXPECT_GE(all + 30, undisturbed.size()) << "at most two ticks of pulses are missing";
    for (std::size_t i = 0; i < after.size(); ++i) {
        ASSERT_EQ(after[i].energy_nj > 0, undisturbed[undisturbed.size() - after.size() + i].energy_nj > 0);
    }
}

/// With the Y sensor watching, a path is burnt only where it has looked: a resume begins with the looks again.
TEST_F(Resume, AWatchedSurfaceIsLookedAtAnewAndNothingIsBurntTwice) {
    const fs::path folder = fresh_folder();
    const std::string examples = std::string(SC_SOURCE_DIR) + "/examples/ras3dm/";
    std::string job = read_file(examples + "job.toml");
    for (const char* file : {"table1.csv", "calibration.toml", "face90_c.csv"}) {
        job = replaced(job, '"' + std::string(file) + '"', '"' + examples + file + '"');
    }
    write_file(folder / "job.toml", job + "[surface]\nmode = \"check\"\nwindow_mm = 1.0\n");
    const std::vector<std::string> watched{(folder / "job.toml").string()};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), watched.front());
        return more;
    };
    for (const std::string at : {"9.5", "14.6", "15.3", "16.2", "16.9"}) {
        fs::remove(folder / "journal.sqlite");
        fs::remove(folder / "retained.bin");
        Cell cell(folder, "killed" + at, {"--kill-host-at", at, "--gap", "11"});
        ASSERT_EQ(cell.scribe(watched), kKilled) << cell.said;
        ASSERT_EQ(cell.scribe(with({"--resume", "--reset-fault"})), 0) << at << cell.said;
        expect_same(cell.end(), undisturbed);
    }
}

TEST_F(Resume, AJournalOfAnotherJobIsRefused) {
    const fs::path folder = fresh_folder();
    Cell cell(folder, "cell", {"--kill-host-at", "9.43", "--gap", "1"});
    ASSERT_EQ(cell.scribe({}), kKilled) << cell.said;
    EXPECT_EQ(cell.scribe({"--face", "90", "--resume"}), 2) << cell.said;
    EXPECT_NE(cell.said.find("is the journal of another job"), std::string::npos) << cell.said;
    ASSERT_EQ(cell.scribe({"--resume"}), 0) << cell.said;
    expect_same(cell.end(), undisturbed);
}

TEST_F(Resume, WithoutResumeAJobThatIsBurntInPartIsRefused) {
    Cell cell(fresh_folder(), "cell", {"--kill-host-at", "10.2", "--gap", "1"});
    ASSERT_EQ(cell.scribe({}), kKilled) << cell.said;
    EXPECT_EQ(cell.scribe({}), 2) << cell.said;
    EXPECT_NE(cell.said.find("--resume goes on with it"), std::string::npos) << cell.said;
    cell.end();
}

}  // namespace
}  // namespace sc::test
