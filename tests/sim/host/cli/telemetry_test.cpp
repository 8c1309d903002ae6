// SPDX-License-Identifier: Apache-2.0
// scribecell telemetry, blackbox and the clock in monitor, as a person runs them.
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <signal.h>

#include "tests/sim/host/cli/program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
        lines.push_back(line);
    }
    return lines;
}

TEST(TelemetryCommand, WritesChannelsAtTheirRates) {
    const fs::path file = fresh_folder() / "run.csv";
    Program program("scribecell", {"telemetry", "--channels", "actual,state,pulses", "--rate", "50", "--rate",
                                   "counters=10", "--seconds", "2", "--out", file.string()});
    ASSERT_EQ(program.wait(), 0) << program.err();
    const auto lines = lines_of(read_file(file));
    ASSERT_GE(lines.size(), 98U);
    ASSERT_LE(lines.size(), 104U);
    EXPECT_EQ(lines[0], "cell_s,host_s,actual_x_mm,actual_y_mm,actual_z_mm,actual_c_deg,state,pulses");
    std::size_t counters = 0;
    for (const std::string& line : lines) {
        counters += line.ends_with(",") ? 0U : 1U;
    }
    EXPECT_NEAR(static_cast<double>(counters), 21.0, 2.0);
    EXPECT_NE(program.err().find(" 0 skipped"), std::string::npos) << program.err();
}

TEST(TelemetryCommand, SaysOneObjectASampleWithTheHostsTime) {
    Program program("scribecell", {"telemetry", "--channels", "all", "--rate", "10", "--seconds", "2", "--json"});
    ASSERT_EQ(program.wait(), 0) << program.err();
    const auto lines = lines_of(program.out());
    ASSERT_GE(lines.size(), 19U);
    const Json last = Json::parse(lines.back());
    // In lock-step the host lives by the cell's clock.
    EXPECT_NEAR(last["host_s"].get<double>(), last["cell_s"].get<double>(), 0.01);
    EXPECT_TRUE(last.contains("following_error_c_deg"));
    EXPECT_TRUE(last.contains("triple_3_mm"));
}

TEST(TelemetryCommand, RefusesWhatTheLineCannotCarryAndSaysWhatItCan) {
    Program program("scribecell", {"telemetry", "--channels", "all", "--rate", "500", "--seconds", "1"});
    EXPECT_EQ(program.wait(), 1);
    EXPECT_NE(program.err().find("160 telemetry_over_budget"), std::string::npos) << program.err();
    EXPECT_NE(program.err().find("may take 23040"), std::string::npos) << program.err();
    EXPECT_NE(program.err().find("would fit"), std::string::npos) << program.err();
    const auto is_bad = [](const std::vector<std::string>& more, const std::string& says) {
        std::vector<std::string> words{"telemetry", "--seconds", "1"};
        words.insert(words.end(), more.begin(), more.end());
        Program bad("scribecell", words);
        EXPECT_EQ(bad.wait(), 2) << says;
        EXPECT_NE(bad.err().find(says), std::string::npos) << bad.err();
    };
    is_bad({"--channels", "actual,depht"}, "depht");
    is_bad({"--rate", "fast"}, "fast");
    is_bad({"--rate", "axes=5"}, "axes=5");
    is_bad({"--rate", "1000"}, "out of range");
}

TEST(MonitorCommand, TellsTheCellsClock) {
    Program program("scribecell", {"monitor", "--once", "--json"});
    ASSERT_EQ(program.wait(), 0) << program.err();
    const Json clock = Json::parse(program.out())["clock"];
    EXPECT_LE(std::abs(clock["offset_s"].get<double>()), clock["uncertainty_ms"].get<double>() * 1e-3);
    EXPECT_LT(clock["uncertainty_ms"].get<double>(), 5.0);
    EXPECT_GE(clock["samples"].get<int>(), 3);
}

TEST(BlackBoxCommand, ShowsWhatLedToAFault) {
    const fs::path folder = fresh_folder();
    write_file(folder / "script.txt", "pulse 60 estop open\n");
    const std::string link = "lockstep:" + (folder / "socket").string();
    Program cell("scribecell-cell",
                 {"--lockstep", (folder / "socket").string(), "--script", (folder / "script.txt").string()});
    ASSERT_TRUE(cell.wait_for_err("socket"));
    // A box holds ten seconds only of a cell that has been on for so long.
    Program wait("scribecell", {"telemetry", "--link", link, "--seconds", "6"});
    ASSERT_EQ(wait.wait(), 0) << wait.err();
    Program scribe("scribecell",
                   {"scribe", "--face", "0", "--link", link, "--journal", (folder / "j.sqlite").string()});
    EXPECT_EQ(scribe.wait(), 1) << scribe.err();

    Program box("scribecell", {"blackbox", "--link", link, "--json"});
    ASSERT_EQ(box.wait(), 0) << box.err();
    const Json said = Json::parse(box.out());
    EXPECT_TRUE(said["frozen"].get<bool>());
    EXPECT_EQ(said["fault"].get<int>(), 1);
    ASSERT_GE(said["samples"].size(), 250U);
    const double span = said["newest_cell_s"].get<double>() - said["samples"][0]["cell_s"].get<double>();
    EXPECT_GE(span, 10.0);
    EXPECT_LT(span, 10.1);
    EXPECT_EQ(said["samples"].back()["state"], "fault");
    EXPECT_EQ(said["events"].back()["text"], "marking -> fault");

    const fs::path file = folder / "fault.csv";
    Program csv("scribecell", {"blackbox", "--link", link, "--out", file.string()});
    ASSERT_EQ(csv.wait(), 0) << csv.err();
    EXPECT_NE(read_file(file).find("1 estop_open"), std::string::npos);
    Program text("scribecell", {"blackbox", "--link", link, "--last", "1"});
    ASSERT_EQ(text.wait(), 0) << text.err();
    EXPECT_NE(text.out().find("frozen by code 1 estop_open"), std::string::npos) << text.out();
    EXPECT_LT(lines_of(text.out()).size(), 60U);
    cell.signal(SIGTERM);
    cell.wait();
}

}  // namespace
}  // namespace sc::test
