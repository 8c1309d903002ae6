// SPDX-License-Identifier: Apache-2.0
// Free paths, burnt by the simulated cell beside crosses and datum lines, and found again; the feed override of a cell
// that runs.
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

const std::string kExamples = std::string(SC_SOURCE_DIR) + "/examples/ras3dm/";
const std::string kSettings = "speed_mm_s = 60.0\npitch_um = 20.0\nenergy_uj = 300.0\n";

/// Across the face from marker to marker; then a mirrors' path round marker 1 that meets its cross; arcs at both ends
/// of a path; a whole circle round the marker.
const std::string kPaths = R"(
[[path]]
name = "by axes"
face_deg = 0.0
frame = "h"
points_mm = [[-314.09, -319.77, -425.944], [-266.127, -319.066, -413.494], [-349.127, -319.999, -385.148]]
actuator = "axes"
)" + kSettings + R"([[path]]
name = "by mirrors"
face_deg = 0.0
frame = "h"
file = "square.csv"
actuator = "galvo"
passes = 2
)" + kSettings + R"(
[[path]]
name = "arcs by axes"
face_deg = 0.0
frame = "h"
points_mm = [[-300.0, -319.4, -400.0], { via = [-290.0, -319.4, -390.0], to = [-280.0, -319.4, -400.0] },
             [-280.0, -319.4, -405.0], { via = [-285.0, -319.4, -410.0], to = [-290.0, -319.4, -405.0] }]
actuator = "axes"
)" + kSettings + R"([[path]]
name = "circle by mirrors"
face_deg = 0.0
frame = "h"
points_mm = [[-320.0, -319.77, -421.0], { via = [-314.0, -319.77, -415.0], to = [-308.0, -319.77, -421.0] },
             { via = [-314.0, -319.77, -427.0], to = [-320.0, -319.77, -421.0] }]
actuator = "galvo"
)" + kSettings;

class FreePaths : public testing::Test {
protected:
    void SetUp() override {
        folder_ = fresh_folder();
        std::string job = read_file(kExamples + "job.toml");
        for (const char* file : {"table1.csv", "calibration.toml", "face90_c.csv"}) {
            const std::string quoted = '"' + std::string(file) + '"';
            job = replaced(job, quoted, '"' + kExamples + file + '"');
        }
        write_file(folder_ / "job.toml", job + kPaths);
        write_file(folder_ / "square.csv",
                   "x,y,z\n-320.09,-319.77,-422.944\n-308.09,-319.77,-422.944\n"
                   "-308.09,-319.77,-418.944\n-320.09,-319.77,-418.944\n");
    }
    void TearDown() override { fs::remove_all(folder_); }
    Json run(const std::vector<std::string>& more, int code) {
        std::vector<std::string> words{"scribe", (folder_ / "job.toml").string(), "--face", "0", "--json"};
        words.insert(words.end(), more.begin(), more.end());
        Program program("scribecell", words);
        EXPECT_EQ(program.wait(), code) << program.err();
        return Json::parse(program.out());
    }
    fs::path folder_;
};

TEST_F(FreePaths, AreBurntBesideCrossesAndFoundAgain) {
    const Json plan = run({"--dry-run"}, 0);
    ASSERT_EQ(plan["paths"].size(), 9U * 2U + 1U + 4U);
    EXPECT_EQ(plan["paths"][20]["name"], "by mirrors");
    EXPECT_EQ(plan["paths"][20]["straight_pieces"], 3);
    EXPECT_EQ(plan["paths"].back()["name"], "circle by mirrors");
    const Json report = run({}, 0);
    EXPECT_EQ(report["complete"], true);
    EXPECT_EQ(report["limit_violations"], 0);
    EXPECT_EQ(report["burnt"]["crosses"], 9);
    EXPECT_EQ(report["burnt"]["lines"], 1);
    EXPECT_EQ(report["burnt"]["stray"], 0);
    ASSERT_EQ(report["paths"].size(), 4U);
    const double pi = std::numbers::pi;
    const double expected[4] = {(49.557 + 87.713) / 0.02, 2.0 * 28.0 / 0.02, (15.0 * pi + 5.0) / 0.02,
                                12.0 * pi / 0.02};
    for (std::size_t i = 0; i < 4; ++i) {
        const Json& path = report["paths"][i];
        EXPECT_EQ(path["whole"], true) << path;
        EXPECT_NEAR(path["pulses"].get<double>(), expected[i], 3.0);
        EXPECT_LT(path["max_um"].get<double>(), 12.0) << path;
        EXPECT_LT(path["rms_um"].get<double>(), 6.0) << path;
        std::printf("%s: max %.2f um, rms %.2f um\n", path["name"].get<std::string>().c_str(),
                    path["max_um"].get<double>(), path["rms_um"].get<double>());
    }
}

TEST_F(FreePaths, AreRefusedWithTheirPlace) {
    write_file(folder_ / "square.csv", "x,y,z\n-320,-319,-423\n-320,-319,-423\n-308,-319,-418\n");
    Program repeated("scribecell", {"scribe", (folder_ / "job.toml").string(), "--dry-run"});
    EXPECT_EQ(repeated.wait(), 2);
    EXPECT_NE(repeated.err().find("square.csv:3: path \"by mirrors\": a place is repeated"), std::string::npos)
        << repeated.err();
}

/// A hatch of three strokes by the axes, round a corner, and a wobble by the mirrors.
TEST_F(FreePaths, AreBurntAsWideAsARecipeSays) {
    write_file(folder_ / "recipe.toml",
               "format = \"scribecell-recipe\"\nversion = 1\nname = \"wide\"\nmaterial = \"iron\"\n"
               "[[entry]]\nid = \"hatched\"\nactuator = \"axes\"\n" +
                   kSettings +
                   "width_um = 160\nfill = \"hatch\"\nfill_step_um = 80\n"
                   "[[entry]]\nid = \"wobbled\"\nactuator = \"galvo\"\n" +
                   kSettings + "width_um = 300\nfill = \"wobble\"\nfill_step_um = 100\n");
    write_file(folder_ / "job.toml",
               "format = \"scribecell-job\"\nversion = 1\nname = \"wide\"\nrecipe = \"recipe.toml\"\ncalibration = \"" +
                   kExamples +
                   "calibration.toml\"\n"
                   "[[path]]\nname = \"hatched\"\nface_deg = 0\nframe = \"h\"\nentry = \"hatched\"\n"
                   "points_mm = [[-310.0, -319.4, -420.0], [-290.0, -319.4, -420.0], [-285.0, -319.4, -410.0]]\n"
                   "[[path]]\nname = \"wobbled\"\nface_deg = 0\nframe = \"h\"\nentry = \"wobbled\"\n"
                   "points_mm = [[-300.0, -319.4, -400.0], [-290.0, -319.4, -400.0]]\n");
    Program program("scribecell", {"scribe", (folder_ / "job.toml").string(), "--json"});
    ASSERT_EQ(program.wait(), 0) << program.err();
    const Json report = Json::parse(program.out());
    EXPECT_EQ(report["complete"], true);
    EXPECT_EQ(report["limit_violations"], 0);
    EXPECT_EQ(report["burnt"]["stray"], 0);
    ASSERT_EQ(report["paths"].size(), 2U);
    const double pi = std::numbers::pi;
    // Ten millimetres of a hundred turns. The curve within the tolerance may cut each turn by 4.5 um of its 150.
    const double expected[2] = {3.0 * (20.0 + 11.18) / 0.02, 100.0 * 0.3 * pi / 0.02};
    const double share[2] = {0.002, 0.03};
    for (std::size_t i = 0; i < 2; ++i) {
        const Json& path = report["paths"][i];
        EXPECT_EQ(path["whole"], true) << path;
        EXPECT_NEAR(path["pulses"].get<double>(), expected[i], share[i] * expected[i]);
        EXPECT_LT(path["max_um"].get<double>(), 12.0) << path;
    }
}

TEST(OverrideOfACell, IsSetAndKept) {
    Program cell("scribecell-cell", {"--pty", "--speed", "5"});
    ASSERT_TRUE(cell.wait_for_out("\n")) << cell.err();
    const std::size_t at = cell.out().find("/dev/pts/");
    ASSERT_NE(at, std::string::npos) << cell.out();
    const std::string link = "serial:" + cell.out().substr(at, cell.out().find_first_of(" \n?\"", at) - at);
    const auto set = [&link](const char* percent) {
        Program program("scribecell", {"override", percent, "--link", link});
        EXPECT_EQ(program.wait(), 0) << program.err();
        return program.out();
    };
    EXPECT_EQ(set("40"), "feed override: 100 % -> 40 %\n");
    EXPECT_EQ(set("200"), "feed override: 40 % -> 200 %\n") << "kept from host to host";
    cell.signal(SIGINT);
    EXPECT_EQ(cell.wait(), 0);
}

}  // namespace
}  // namespace sc::test
