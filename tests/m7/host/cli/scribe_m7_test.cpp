// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/sim/host/cli/program.hpp"

namespace sc::test {
namespace {

using Json = nlohmann::json;

Json scribe(std::vector<std::string> options) {
    std::vector<std::string> words{"scribe", "--json"};
    words.insert(words.end(), options.begin(), options.end());
    Program program("scribecell", words);
    EXPECT_EQ(program.wait(), 0) << program.err();
    return Json::parse(program.out(), nullptr, false);
}

TEST(ScribeOnM7, MainJobHasTheSameCommandHashAndItsCost) {
    const Json here = scribe({});
    const Json there = scribe({"--board", "m7", "--m7-image", SC_M7_IMAGE});
    EXPECT_EQ(there.at("command_trace_sha256"), here.at("command_trace_sha256"));
    EXPECT_EQ(there.at("faces"), here.at("faces"));
    EXPECT_EQ(here.at("board"), "sim");
    EXPECT_TRUE(here.at("board_figures").is_null());
    EXPECT_EQ(there.at("board"), "mps2_an500");
    const Json& figures = there.at("board_figures");
    EXPECT_GT(figures.at("instructions_marking").at("servo_max").at("count"), 1000);
    EXPECT_GT(figures.at("instructions").at("plan_max").at("count"), 100);
    EXPECT_GT(figures.at("stack_used_bytes"), 500);
}

TEST(ScribeOnM7, ReportNamesTheBoardAndItsInstructions) {
    Program program("scribecell", {"scribe", "--face", "90", "--board", "m7", "--m7-image", SC_M7_IMAGE});
    EXPECT_EQ(program.wait(), 0) << program.err();
    for (const char* part : {"Controller on mps2_an500", "marking ticks", "stack used"}) {
        EXPECT_NE(program.out().find(part), std::string::npos) << part;
    }
}

TEST(ScribeOnM7, RefusesWhatCannotBeBeforeAnythingMoves) {
    Program no_image("scribecell", {"scribe", "--board", "m7", "--m7-image", "nowhere.elf"});
    EXPECT_EQ(no_image.wait(), 2);
    EXPECT_NE(no_image.err().find("nowhere.elf"), std::string::npos) << no_image.err();
    const std::string not_arm = "/proc/self/exe";
    Program wrong_image("scribecell", {"scribe", "--board", "m7", "--m7-image", not_arm});
    EXPECT_EQ(wrong_image.wait(), 2);
    EXPECT_NE(wrong_image.err().find("no ELF file for Arm"), std::string::npos) << wrong_image.err();
    Program no_sim("scribecell", {"scribe", "--board", "m7", "--link", "tcp:127.0.0.1:1"});
    EXPECT_EQ(no_sim.wait(), 2);
    EXPECT_NE(no_sim.err().find("--board"), std::string::npos) << no_sim.err();
    Program no_board("scribecell", {"scribe", "--board", "m8"});
    EXPECT_EQ(no_board.wait(), 2);
}

}  // namespace
}  // namespace sc::test
