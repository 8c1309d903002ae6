// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/formats/calibration_set.hpp"
#include "host/formats/job.hpp"
#include "host/formats/part.hpp"
#include "host/formats/points.hpp"
#include "host/formats/pulse_trace.hpp"
#include "host/formats/recipe.hpp"
#include "host/formats/scan_set.hpp"
#include "host/formats/table.hpp"
#include "host/formats/target.hpp"
#include "tests/unit/host/formats/support.hpp"

/// Damaged files are read, or refused by an InputError that names the file; nothing else may come out. The damage is
/// drawn from a fixed seed.

namespace sc::host {
namespace {

using Reader = std::function<void(const std::filesystem::path&)>;

class Mutator {
public:
    explicit Mutator(std::uint64_t seed) : random_(seed) {}

    std::string operator()(std::string text) {
        const std::size_t hits = 1 + below(4);
        for (std::size_t i = 0; i < hits && !text.empty(); ++i) {
            hit(text);
        }
        return text;
    }

private:
    std::size_t below(std::size_t limit) { return static_cast<std::size_t>(random_() % limit); }

    void hit(std::string& text) {
        static const std::vector<std::string> words{"nan",
                                                    "inf",
                                                    "-",
                                                    "1e999",
                                                    "0",
                                                    "-1",
                                                    "99999999999999999999",
                                                    "\"",
                                                    "[",
                                                    "]",
                                                    "=",
                                                    ",",
                                                    ";",
                                                    "#",
                                                    "\n",
                                                    "\r\n",
                                                    "[[face]]",
                                                    "12,5",
                                                    "\xff",
                                                    std::string(1, '\0'),
                                                    "{",
                                                    "}",
                                                    "true",
                                                    "1979-05-27",
                                                    "0x1F",
                                                    "'''",
                                                    "\"\"\""};
        const std::size_t at = below(text.size());
        switch (below(6)) {
            case 0: text[at] = static_cast<char>(random_() & 0xFFU); break;
            case 1: text.erase(at, 1 + below(20)); break;
            case 2: text.insert(at, words[below(words.size())]); break;
            case 3: text.resize(at); break;
            case 4: text.insert(at, text.substr(below(text.size()), below(60))); break;
            default: std::swap(text[at], text[below(text.size())]); break;
        }
    }

    std::mt19937_64 random_;
};

void expect_read_or_refused(const std::string& good, const Reader& read, int rounds) {
    const test::TempDir dir;
    const auto untouched = dir.write("good", good);
    ASSERT_NO_THROW(read(untouched));
    Mutator mutate(20260131);
    int refused = 0;
    for (int i = 0; i < rounds; ++i) {
        const auto path = dir.write("bad", mutate(good));
        try {
            read(path);
        } catch (const InputError& error) {
            ++refused;
            ASSERT_EQ(error.file(), path.string());
            ASSERT_FALSE(error.problem().empty());
            ASSERT_FALSE(error.action().empty());
            ASSERT_EQ(std::string_view(error.what()).find('\n'), std::string_view::npos) << error.what();
        }
    }
    EXPECT_GT(refused, rounds / 4);
}

std::string example(const std::string& name) {
    return test::slurp(std::string(SC_SOURCE_DIR "/examples/ras3dm/") + name);
}

constexpr int kRounds = 300;

TEST(DamagedFile, Table) {
    expect_read_or_refused(example("table1.csv"), [](const auto& p) { static_cast<void>(read_table(p)); }, kRounds);
}
TEST(DamagedFile, Points) {
    expect_read_or_refused(example("face90_c.csv"), [](const auto& p) { static_cast<void>(read_points(p)); }, kRounds);
}
TEST(DamagedFile, Job) {
    expect_read_or_refused(example("job.toml"), [](const auto& p) { static_cast<void>(read_job(p)); }, kRounds);
}
TEST(DamagedFile, Calibration) {
    // Without its hash, which would refuse nearly all before anything is looked at.
    std::string text = example("calibration.toml");
    const std::size_t at = text.find("sha256 = ");
    text.erase(at, text.find('\n', at) + 1 - at);
    expect_read_or_refused(
        text, [](const auto& p) { static_cast<void>(compensation_of(read_calibration(p))); }, kRounds);
}
TEST(DamagedFile, SealedCalibrationIsNeverReadAsAnother) {
    const CalibrationSet good = read_calibration(SC_SOURCE_DIR "/examples/ras3dm/calibration.toml");
    const test::TempDir dir;
    Mutator mutate(3);
    int read = 0;
    for (int i = 0; i < kRounds; ++i) {
        try {
            const CalibrationSet set = read_calibration(dir.write("c.toml", mutate(example("calibration.toml"))));
            const bool seal_is_gone = test::slurp(dir / "c.toml").find(good.sha256) == std::string::npos;
            ++read;
            EXPECT_TRUE(set.sha256 == good.sha256 || seal_is_gone);
        } catch (const InputError&) {
            continue;
        }
    }
    EXPECT_LT(read, kRounds / 4);
}
TEST(DamagedFile, ScanSet) {
    const std::string text =
        "format = \"scribecell-scan-set\"\nversion = 1\nid = \"s\"\ntime = \"2026-01-15T09:30:00Z\"\n[[view]]\n"
        "id = \"v\"\nc_deg = -90.0\ncloud = \"v.ply\"\n[view.robot_pose]\nconvention = \"f_from_b\"\n"
        "rotation = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]\ntranslation_mm = [1000, 0, 0]\n[[view.marker]]\nid = 7\n"
        "place_mm = [1.5, -2.5, 600.25]\nsigma_um = 12.5\n";
    expect_read_or_refused(text, [](const auto& p) { static_cast<void>(read_scan_set(p)); }, kRounds);
}
TEST(DamagedFile, Target) {
    const std::string text =
        "format = \"scribecell-target\"\nversion = 1\nid = \"t\"\nkind = \"mobile\"\n[[marker]]\nid = 7\n"
        "place_mm = [1.5, -2.5, 600.25]\nsigma_um = 1.5\n[[step]]\nid = 1\nheight_mm = 5.01\nuncertainty_um = 0.5\n"
        "markers = [7]\n";
    expect_read_or_refused(text, [](const auto& p) { static_cast<void>(read_target(p)); }, kRounds);
}
TEST(DamagedFile, Part) {
    const std::string text =
        "format = \"scribecell-part\"\nversion = 1\nid = \"p\"\n[[machined]]\nid = \"f\"\nkind = \"plane\"\n"
        "point_mm = [0, 32, 42.5]\nnormal = [0, 0, 1]\nmin_allowance_mm = 0.5\n[[datum]]\nid = \"A\"\n"
        "point_mm = [0, 0, 42.5]\nnormal = [0, 1, 0]\n[as_cast]\ninside_mm = 0.2\noutside_mm = 1\n";
    expect_read_or_refused(text, [](const auto& p) { static_cast<void>(read_part(p)); }, kRounds);
}
TEST(DamagedFile, Recipe) {
    const std::string text =
        "format = \"scribecell-recipe\"\nversion = 1\nname = \"r\"\nmaterial = \"m\"\n[[entry]]\nid = \"e\"\n"
        "actuator = \"axes\"\nspeed_mm_s = 60\npitch_um = 20\nenergy_uj = 300\n";
    expect_read_or_refused(text, [](const auto& p) { static_cast<void>(read_recipe(p)); }, kRounds);
}
TEST(DamagedFile, PulseTrace) {
    const std::string header =
        R"({"axis":{"point_m":[0,0,0],"direction":[0,0,1]},"errors":[{"name":"a","value":1,"unit":"um"}]})";
    std::string bytes(trace::kPulseMagic.begin(), trace::kPulseMagic.end());
    bytes += static_cast<char>(header.size());
    bytes += std::string(3, '\0') + header + std::string(4 * trace::kPulseRecordSize, '\x05');
    expect_read_or_refused(bytes, [](const auto& p) { static_cast<void>(read_pulse_trace(p)); }, kRounds);
}
TEST(DamagedFile, SampleTrace) {
    std::string bytes(trace::kSampleMagic.begin(), trace::kSampleMagic.end());
    bytes += std::string("\x02\0\0\0{}", 6) + std::string(20 * trace::kSampleRecordSize, '\0');
    expect_read_or_refused(bytes, [](const auto& p) { for_each_sample(p, [](const auto&, auto) {}); }, kRounds);
}

}  // namespace
}  // namespace sc::host
