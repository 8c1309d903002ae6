// SPDX-License-Identifier: Apache-2.0
// What ends a job early: faults provoked in the simulated cell, a cut link, Ctrl-C, a killed host. Each must leave the
// cell at rest, the laser off, the right number told, and a journal that says how far it came.
#include <cstdint>
#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <signal.h>

#include "host/formats/journal.hpp"
#include "host/formats/pulse_trace.hpp"
#include "tests/sim/host/cli/program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::int64_t kGuardNs = 110'000;
constexpr std::int64_t kLinkNs = 150'000'000;

/// From the script's first event to the last pulse of all; negative when none came after it.
std::int64_t last_pulse_after(const Json& cell) {
    return cell["last_pulse_ns"].get<std::int64_t>() - cell["script_events"][0]["t_ns"].get<std::int64_t>();
}

/// The example job with many passes: it runs for so long that a signal always meets it half done.
std::string long_job(const fs::path& folder) {
    fs::copy(fs::path(SC_SOURCE_DIR) / "examples/ras3dm", folder / "job", fs::copy_options::recursive);
    std::string job = read_file(folder / "job/job.toml");
    const std::size_t line = job.find("[datum_line]");
    job = job.substr(0, line) + replaced(job.substr(line), "passes = 1", "passes = 40");
    write_file(folder / "job/job.toml", job);
    return (folder / "job/job.toml").string();
}

/// One fault: when, what, which number, how soon the last pulse (0: not judged by time).
struct Case {
    const char* name;
    const char* script;
    int code;
    std::int64_t laser_off_ns;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class ScribeFault : public ::testing::TestWithParam<Case> {};

TEST_P(ScribeFault, EndsInFaultWithItsNumberAndTheLaserOff) {
    const Case& c = GetParam();
    const fs::path folder = fresh_folder();
    write_file(folder / "script.txt", c.script);
    Program program("scribecell", {"scribe", "--json", "--face", "0", "--out", (folder / "out").string(), "--script",
                                   (folder / "script.txt").string()});
    EXPECT_EQ(program.wait(), 1) << program.err();
    const Json json = Json::parse(program.out(), nullptr, false);
    ASSERT_TRUE(json.is_object()) << program.out();
    EXPECT_EQ(json["state"], "fault");
    EXPECT_EQ(json["error"]["code"], c.code) << json["error"];
    EXPECT_NE(json["error"]["action"], "");
    EXPECT_NE(program.err().find("the journal says"), std::string::npos) << program.err();

    const Json cell = Json::parse(read_file(folder / "out/cell.json"));
    EXPECT_EQ(cell["state"], "fault");
    EXPECT_EQ(cell["pulses_not_allowed"], 0);
    ASSERT_FALSE(cell["script_events"].empty());
    if (c.laser_off_ns > 0) {
        EXPECT_LE(last_pulse_after(cell), c.laser_off_ns);
    }
    const host::JournalSummary journal = host::read_journal(folder / "out/journal.sqlite");
    EXPECT_EQ(journal.outcome, host::JobOutcome::failed);
    ASSERT_TRUE(journal.last);
    EXPECT_GT(journal.last->fired, 0U);
    EXPECT_LT(journal.last->fired, journal.job.items);
    EXPECT_GE(journal.last->sent, journal.last->fired);
    fs::remove_all(folder);
}

// Pulse 1000 leaves while the galvo burns crosses, pulse 5000 while the axes burn the datum line.
INSTANTIATE_TEST_SUITE_P(Each, ScribeFault,
                         ::testing::Values(Case{"estop", "pulse 1000 estop open\n", 1, kGuardNs},
                                           Case{"interlock", "pulse 1000 interlock open\n", 2, kGuardNs},
                                           Case{"laser_alarm", "pulse 1000 laser alarm\n", 3, kGuardNs},
                                           Case{"galvo", "pulse 1000 galvo fail\n", 4, kGuardNs},
                                           Case{"drive_fault", "pulse 5000 drive x fault 0x2310\n", 5, 0},
                                           Case{"drive_silent", "pulse 5000 drive x silent\n", 6, 0},
                                           Case{"drive_stall", "pulse 5000 drive x stall\n", 7, 0},
                                           Case{"encoder_frozen", "pulse 5000 drive x freeze\n", 8, 0}),
                         [](const auto& test) { return std::string(test.param.name); });

/// Nothing moves and no pulse leaves in the last ten ticks of a cell's life.
void expect_at_rest(const fs::path& out) {
    std::vector<trace::SampleRecord> samples;
    host::for_each_sample(out / "samples.trace", [&](const trace::SampleRecord& sample, auto) {
        samples.push_back(sample);
        if (samples.size() > 10) {
            samples.erase(samples.begin());
        }
    });
    ASSERT_EQ(samples.size(), 10U);
    for (const trace::SampleRecord& sample : samples) {
        EXPECT_EQ(sample.gate, 0);
        EXPECT_EQ(sample.set_point, samples.front().set_point);
    }
}

TEST(ScribeLink, ACutLinkEndsInLinkLost) {
    const fs::path folder = fresh_folder();
    write_file(folder / "script.txt", "pulse 5000 link cut\n");
    Program program("scribecell", {"scribe", "--json", "--face", "0", "--out", (folder / "out").string(), "--script",
                                   (folder / "script.txt").string()});
    EXPECT_EQ(program.wait(), 1) << program.err();
    EXPECT_EQ(Json::parse(program.out())["error"]["name"], "link");
    const Json cell = Json::parse(read_file(folder / "out/cell.json"));
    EXPECT_EQ(cell["state"], "fault");
    EXPECT_EQ(cell["first_fault"], "link_lost");
    EXPECT_LE(last_pulse_after(cell), kLinkNs);
    expect_at_rest(folder / "out");
    fs::remove_all(folder);
}

TEST(ScribeLink, AJobGoesOnAfterAShortCutAndNoPulseIsMissing) {
    const fs::path folder = fresh_folder();
    Program plain("scribecell", {"scribe", "--json"});
    ASSERT_EQ(plain.wait(), 0) << plain.err();
    const Json undisturbed = Json::parse(plain.out());
    // A second of silence in the middle of the job.
    const int middle = static_cast<int>(undisturbed["cell_seconds"].get<double>() / 2.0);
    write_file(folder / "script.txt",
               "at " + std::to_string(middle) + " link cut\nat " + std::to_string(middle + 1) + " link restore\n");
    Program program("scribecell", {"scribe", "--json", "--out", (folder / "out").string(), "--script",
                                   (folder / "script.txt").string()});
    EXPECT_EQ(program.wait(), 0) << program.err();
    const Json report = Json::parse(program.out());
    EXPECT_EQ(report["complete"], true);
    EXPECT_EQ(report["pulses"], undisturbed["pulses"]);
    EXPECT_GT(report["cell_seconds"].get<double>(), undisturbed["cell_seconds"].get<double>() + 0.5);
    fs::remove_all(folder);
}

TEST(ScribeEnd, CtrlCBringsTheCellToRestAndSaysHowFarItCame) {
    for (const int number : {SIGINT, SIGTERM}) {
        const fs::path folder = fresh_folder();
        Program program("scribecell", {"scribe", long_job(folder), "--json", "--out", (folder / "out").string()});
        ASSERT_TRUE(program.wait_for_err(" 10 %")) << program.err();
        program.signal(number);
        EXPECT_EQ(program.wait(), 130) << program.err();
        const Json json = Json::parse(program.out(), nullptr, false);
        ASSERT_TRUE(json.is_object()) << program.out();
        EXPECT_EQ(json["error"]["name"], "interrupted");
        EXPECT_EQ(json["state"], "disabled");
        const Json cell = Json::parse(read_file(folder / "out/cell.json"));
        EXPECT_EQ(cell["state"], "disabled");
        expect_at_rest(folder / "out");
        const host::JournalSummary journal = host::read_journal(folder / "out/journal.sqlite");
        EXPECT_EQ(journal.outcome, host::JobOutcome::aborted);
        EXPECT_GT(journal.last->fired, 0U);
        EXPECT_LT(journal.last->fired, journal.job.items);
        fs::remove_all(folder);
    }
}

TEST(ScribeEnd, AKilledHostLeavesTheCellAtRestAndTheJournalSaysHowFarItCame) {
    adopt_orphans();
    const fs::path folder = fresh_folder();
    {
        Program program("scribecell", {"scribe", long_job(folder), "--out", (folder / "out").string(), "--journal",
                                       (folder / "j.sqlite").string()});
        ASSERT_TRUE(program.wait_for_err(" 10 %")) << program.err();
        program.signal(SIGKILL);
        EXPECT_EQ(program.wait(), 128 + SIGKILL);
    }
    wait_for_orphans();
    const Json cell = Json::parse(read_file(folder / "out/cell.json"));
    EXPECT_EQ(cell["state"], "fault");
    EXPECT_EQ(cell["first_fault"], "link_lost");
    EXPECT_EQ(cell["pulses_not_allowed"], 0);
    expect_at_rest(folder / "out");
    const host::JournalSummary journal = host::read_journal(folder / "j.sqlite");
    EXPECT_EQ(journal.outcome, host::JobOutcome::open);
    ASSERT_TRUE(journal.last);
    EXPECT_GT(journal.last->fired, 0U);
    EXPECT_GE(journal.last->sent, journal.last->fired);
    fs::remove_all(folder);
}

TEST(ScribeLive, BurnsOverATcpPortInRealTime) {
    Program cell("scribecell", {"cell", "--tcp", "0"});
    ASSERT_TRUE(cell.wait_for_out("\n")) << cell.err();
    const std::string port = cell.out().substr(0, cell.out().find('\n'));
    Program program("scribecell", {"scribe", "--json", "--face", "0", "--link", "tcp:127.0.0.1:" + port});
    EXPECT_EQ(program.wait(), 0) << program.err();
    const Json json = Json::parse(program.out());
    EXPECT_EQ(json["state"], "disabled");
    EXPECT_EQ(json["progress"]["fired"], json["progress"]["items"]);
    cell.signal(SIGTERM);
    EXPECT_EQ(cell.wait(), 0) << cell.err();
}

}  // namespace
}  // namespace sc::test
