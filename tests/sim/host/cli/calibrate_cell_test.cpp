// SPDX-License-Identifier: Apache-2.0
// Calibration done on the simulated cell itself, by the programs as a person would run them.
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <toml++/toml.h>

#include "program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json run_json(std::vector<std::string> words, int expected = 0) {
    words.emplace_back("--json");
    Program program("scribecell", words);
    EXPECT_EQ(program.wait(), expected) << program.err() << program.out();
    return json::parse(program.out(), nullptr, false);
}

double all_95(const json& result) { return result.at("faces").back().at("axis_95_um").get<double>(); }

TEST(CalibratePlate, GivesTransformAndFieldFromWhatWasBurnt) {
    const auto folder = fresh_folder();
    const json found = run_json({"calibrate", "plate", "--across", "3", "--up", "5", "--out", (folder / "a").string()});
    EXPECT_EQ(found.at("crosses").size(), 270U);
    EXPECT_TRUE(found.at("wrong").empty());
    EXPECT_LT(found.at("place_sigma_um").get<double>(), 15.0);
    EXPECT_NEAR(found.at("rayleigh_mm").get<double>(), 0.6, 0.1);
    EXPECT_NEAR(found.at("rms_um").get<double>(), 7.5, 2.0);
    const std::string plan = (folder / "a/plan.csv").string();
    const std::string seen = (folder / "a/seen/crosses.csv").string();
    // Without widths nothing shows y.
    const json blind = run_json({"calibrate", "plate", "--plan", plan, "--measured", seen, "--no-widths"}, 2);
    EXPECT_NE(blind.dump().find("1.00"), std::string::npos) << blind.dump();
    // Two crosses with each other's number are named.
    const std::string text = read_file(seen);
    write_file(folder / "wrong.csv",
               replaced(replaced(replaced(text, "\n100,", "\n777,"), "\n101,", "\n100,"), "\n777,", "\n101,"));
    const json named = run_json({"calibrate", "plate", "--plan", plan, "--measured", (folder / "wrong.csv").string()});
    EXPECT_EQ(named.at("wrong"), json::array({101, 100}));
    // A job runs on the set.
    Program scribe("scribecell", {"scribe", "--face", "0", "--dry-run", "--calibration",
                                  (folder / "a/calibration.toml").string(), "--json"});
    EXPECT_EQ(scribe.wait(), 0) << scribe.err();
}

TEST(CalibrateFocus, FindsTheSurfaceOfThePlate) {
    const json found = run_json({"calibrate", "focus"});
    EXPECT_NEAR(found.at("y_mm").get<double>(), -210.0, 5e-3 * found.at("sigma_um").get<double>() + 2e-3);
    EXPECT_LT(found.at("sigma_um").get<double>(), 30.0);
    EXPECT_NEAR(found.at("rayleigh_mm").get<double>(), 0.6, 0.15);
    // A ladder beside the focus is refused.
    run_json({"calibrate", "focus", "--at-mm=-225,-208,-250", "--half-mm", "0.5"}, 2);
}

TEST(CalibratePointing, GoesOnWhereItStopped) {
    const auto folder = fresh_folder();
    const std::string out = (folder / "p").string();
    write_file(folder / "keys.txt", "tttttttttt t x");
    const json stopped = run_json({"calibrate", "pointing", "--out", (folder / "k").string(), "--keys",
                                   (folder / "keys.txt").string(), "--looks", "9"},
                                  2);
    EXPECT_NE(stopped.dump().find("too few markers"), std::string::npos);
    run_json({"calibrate", "pointing", "--out", out, "--markers", "4"});
    const std::string first = read_file(folder / "p/pointing.csv");
    const json found = run_json({"calibrate", "pointing", "--out", out, "--markers", "6"});
    EXPECT_EQ(found.at("markers"), 6);
    EXPECT_EQ(read_file(folder / "p/pointing.csv").substr(0, first.size()), first);
    Program rigid("scribecell", {"calibrate", "rigid", "--from", (folder / "p/mobile/markers.csv").string(), "--to",
                                 (folder / "p/h.csv").string(), "--name", "h_from_c", "--json"});
    EXPECT_EQ(rigid.wait(), 0) << rigid.err();
    EXPECT_LT(json::parse(rigid.out()).at("rms_um").get<double>(), 40.0);
}

TEST(CalibrateAll, IsWorthWhatItSaysAndEachPartEarnsIt) {
    const auto folder = fresh_folder();
    const std::vector<std::string> quick{"calibrate", "all", "--across", "3", "--up", "5"};
    const auto with = [&quick](std::vector<std::string> more) {
        more.insert(more.begin(), quick.begin(), quick.end());
        return more;
    };
    const json whole = run_json(with({"--out", (folder / "a").string()}));
    ASSERT_EQ(whole.at("faces").size(), 5U);
    EXPECT_EQ(whole.at("faces").back().at("markers"), 36);
    EXPECT_LT(all_95(whole), 40.0);
    // Beside the focus with the galvo at zero, whose mirrors are off by 35 and -22 um; its beam leans over 125 mm.
    const std::string set = read_file(folder / "a/calibration.toml");
    const toml::table table = toml::parse(set);
    const auto origin = table["y_sensor"]["origin_mm"];
    EXPECT_NEAR(origin[0].value_or(0.0), 30.150 + 125.21 * 0.7e-3 - 0.035, 0.015);
    EXPECT_NEAR(origin[2].value_or(0.0), -0.180 - 125.21 * 0.5e-3 + 0.022, 0.015);
    // Beams of the triple head: y, z, leans towards y and z (mrad), from x = 150 mm.
    constexpr double kBeams[3][4] = {
        {-490.08, -292.30, 1.4, -0.9}, {-540.15, -378.75, -0.8, 1.1}, {-439.90, -378.98, 0.6, 0.5}};
    for (std::size_t k = 0; k < 3; ++k) {
        const auto ray = table["triple_head"][k];
        const double way = 150.0 - ray["origin_mm"][0].value_or(0.0);
        EXPECT_NEAR(ray["origin_mm"][1].value_or(0.0), kBeams[k][0] + 1e-3 * way * kBeams[k][2], 0.15) << k;
        EXPECT_NEAR(ray["origin_mm"][2].value_or(0.0), kBeams[k][1] + 1e-3 * way * kBeams[k][3], 0.2) << k;
        EXPECT_NEAR(ray["direction"][1].value_or(1.0), 1e-3 * kBeams[k][2], 5e-3) << k;
        EXPECT_NEAR(ray["direction"][2].value_or(1.0), 1e-3 * kBeams[k][3], 7e-3) << k;
    }
    // A second call has nothing left to do but the experiment.
    Program again("scribecell", with({"--out", (folder / "a").string(), "--json"}));
    EXPECT_EQ(again.wait(), 0);
    EXPECT_NE(again.err().find("plate: done before"), std::string::npos) << again.err();
    EXPECT_EQ(json::parse(again.out()).at("faces"), whole.at("faces"));
    // Other options are another cell.
    run_json(with({"--out", (folder / "a").string(), "--seed", "2"}), 2);
    for (const char* part : {"references", "axis"}) {
        const json less = run_json(with({"--out", (folder / part).string(), "--without", part, "--without", "lag",
                                         "--without", "y-sensor", "--without", "triple-head"}));
        EXPECT_GT(all_95(less), 1.5 * all_95(whole)) << part;
    }
}

}  // namespace
}  // namespace sc::test
