// SPDX-License-Identifier: Apache-2.0
// `scribe --preview` through the built programs: the job is traced, nothing is burnt.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/sim/host/cli/program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

Json preview(std::vector<std::string> arguments, int exit_code = 0) {
    arguments.insert(arguments.begin(), {"scribe", "--preview", "--json", "--face", "0"});
    Program program("scribecell", arguments);
    EXPECT_EQ(program.wait(), exit_code) << program.err();
    Json json = Json::parse(program.out(), nullptr, false);
    EXPECT_TRUE(json.is_object()) << program.out();
    return json;
}

fs::path script(const fs::path& folder, const std::string& text) {
    const fs::path file = folder / "script.txt";
    std::ofstream(file) << text;
    return file;
}

TEST(ScribePreview, TracesTheJobAsOftenAsAskedAndBurnsNothing) {
    const fs::path folder = fresh_folder();
    const Json once = preview({"--out", (folder / "out").string()});
    const Json twice = preview({"--rounds", "2"});
    EXPECT_EQ(once["preview"]["rounds"], 1);
    EXPECT_EQ(twice["preview"]["rounds"], 2);
    EXPECT_FALSE(fs::exists(folder / "out/journal.sqlite"));
    for (const Json& outcome : {once, twice}) {
        EXPECT_EQ(outcome["state"], "disabled");
        EXPECT_EQ(outcome["cell"]["pulses"], 0);
        EXPECT_EQ(outcome["cell"]["unlit"], 0);
        EXPECT_EQ(outcome["cell"]["pulses_not_allowed"], 0);
        EXPECT_EQ(outcome["cell"]["master_oscillator_seconds"], 0.0);
        EXPECT_EQ(outcome["cell"]["gate_seconds"], 0.0);
        EXPECT_EQ(outcome["cell"]["shutter_seconds"], 0.0);
    }
    // At 100 mm/s or less the lines take their length at least.
    const double seconds = once["cell"]["guide_seconds"].get<double>();
    EXPECT_GE(seconds, once["preview"]["marked_mm"].get<double>() / 100.0 * 0.98);
    EXPECT_NEAR(twice["cell"]["guide_seconds"].get<double>(), 2.0 * seconds, 0.01);
}

TEST(ScribePreview, WithTheKeyAtSetupItTracesAndABurnIsRefused) {
    const fs::path folder = fresh_folder();
    const std::string file = script(folder, "at 0.1 key setup\nat 0.1 interlock open\n").string();
    EXPECT_EQ(preview({"--script", file})["preview"]["rounds"], 1);
    Program burn("scribecell", {"scribe", "--json", "--face", "0", "--script", file});
    EXPECT_EQ(burn.wait(), 1);
    const Json json = Json::parse(burn.out());
    EXPECT_EQ(json["error"]["name"], "key_not_production");
    EXPECT_EQ(json["cell"]["pulses"], 0);
}

TEST(ScribePreview, WithTheKeyOffItIsRefused) {
    const fs::path folder = fresh_folder();
    const Json json = preview({"--script", script(folder, "at 0.1 key off\n").string()}, 1);
    EXPECT_EQ(json["error"]["name"], "key_off");
}

TEST(ScribePreview, GoesOnUntilCtrlCInACellThatIsWatched) {
    const fs::path folder = fresh_folder();
    Program cell("scribecell-cell", {"--tcp", "0", "--out", (folder / "cell").string()});
    ASSERT_TRUE(cell.wait_for_out("\n")) << cell.err();
    const std::string port = cell.out().substr(0, cell.out().find('\n'));
    Program program("scribecell", {"scribe", "--preview", "--json", "--face", "0", "--link", "tcp:127.0.0.1:" + port});
    ASSERT_TRUE(program.wait_for_err("round 1")) << program.err();
    program.signal(SIGINT);
    EXPECT_EQ(program.wait(), 0) << program.err();
    const Json json = Json::parse(program.out());
    EXPECT_EQ(json["preview"]["rounds"], 0);
    EXPECT_EQ(json["preview"]["stopped"], true);
    EXPECT_EQ(json["state"], "disabled");
    cell.signal(SIGTERM);
    EXPECT_EQ(cell.wait(), 0);
    std::ifstream report(folder / "cell/cell.json");
    const Json seen = Json::parse(report);
    EXPECT_EQ(seen["pulses"], 0);
    EXPECT_EQ(seen["master_oscillator_seconds"], 0.0);
}

TEST(ScribePreview, BadUseIsRefused) {
    for (const std::vector<std::string>& words : {std::vector<std::string>{"scribe", "--rounds", "2"},
                                                  {"scribe", "--preview", "--dry-run"},
                                                  {"scribe", "--preview", "--rounds", "0"},
                                                  {"scribe", "--preview", "--journal", "j.sqlite"}}) {
        Program program("scribecell", words);
        EXPECT_EQ(program.wait(), 2) << words.back();
    }
}

}  // namespace
}  // namespace sc::test
