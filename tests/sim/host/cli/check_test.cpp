// SPDX-License-Identifier: Apache-2.0
// `scribecell check` and `scribecell plot`, as a person runs them: on the main job's trace and on motions in CSV.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/sim/host/cli/program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

struct Answer {
    int code = -1;
    std::string out;
    std::string err;
};

Answer run(const std::vector<std::string>& arguments) {
    Program program("scribecell", arguments);
    Answer answer;
    answer.code = program.wait();
    answer.out = program.out();
    answer.err = program.err();
    return answer;
}

/// Distance of a move that speeds up and slows down by constant jerk only: 200 m/s³ · scale, 20 ms a phase.
double jerk_move(double t, double scale) {
    const auto cube = [&](double since) { return since > 0.0 ? scale * 200.0 * since * since * since / 6.0 : 0.0; };
    return cube(t) - 2.0 * cube(t - 0.02) + 2.0 * cube(t - 0.06) - cube(t - 0.08);
}

/// A motion along X, then back along Y of C too: both moves at rest in between.
std::string motion_csv(double scale, double sideways_um = 0.0) {
    std::string text = "t_s,x_m,y_m,z_m,c_deg\n";
    for (int n = 0; n <= 200; ++n) {
        const double x = jerk_move(1e-3 * (n - 5), scale);
        const double y = jerk_move(1e-3 * (n - 105), 1.0);
        const double s = std::sin(3.14159265358979 * x / jerk_move(1.0, scale));
        char line[160];
        std::snprintf(line, sizeof(line), "%.3f,%.12f,%.12f,%.12f,%.9f\n", 1e-3 * n, x, y, 1e-6 * sideways_um * s * s,
                      -9.0 * y);
        text += line;
    }
    return text;
}

class Check : public ::testing::Test {
protected:
    void SetUp() override { folder_ = fresh_folder(); }
    void TearDown() override { fs::remove_all(folder_); }
    [[nodiscard]] std::string file(const std::string& name) const { return (folder_ / name).string(); }
    fs::path folder_;
};

TEST_F(Check, JudgesEveryPulseOfARun) {
    ASSERT_EQ(run({"scribe", "--face", "0", "--out", file("run")}).code, 0);
    const std::string trace = file("run/samples.trace");
    EXPECT_EQ(run({"check", trace}).code, 0);
    for (const char* limit : {"--pitch", "--energy", "--pulse-energy"}) {
        const Answer answer = run({"check", trace, limit, "0.2", "--json"});
        EXPECT_EQ(answer.code, 1) << limit;
        const Json json = Json::parse(answer.out);
        EXPECT_GT(json["pulses"]["violations"].get<int>(), 0) << limit;
        EXPECT_EQ(json["limit_violations"], 0);
    }
    EXPECT_EQ(run({"check", trace, "--pitch", "0"}).code, 2);

    // One pulse too few, and one 3 um late: named with their path and number.
    std::string pulses = read_file(file("run/pulses.trace"));
    const std::size_t records =
        12 + static_cast<unsigned char>(pulses[8]) + 256U * static_cast<unsigned char>(pulses[9]);
    std::string fewer = pulses;
    fewer.erase(records + 77U * 50U, 77U);
    write_file(file("fewer.trace"), fewer);
    Answer answer = run({"check", trace, "--pulses", file("fewer.trace"), "--items", file("run/job.items")});
    EXPECT_EQ(answer.code, 1);
    EXPECT_NE(answer.out.find("path 0 pass 0: 200 pulses, and it has 201"), std::string::npos) << answer.out;
    EXPECT_NE(answer.out.find("pulse 50"), std::string::npos) << answer.out;

    write_file(file("broken.items"), read_file(file("run/job.items")).substr(0, 300));
    answer = run({"check", trace, "--items", file("broken.items")});
    EXPECT_EQ(answer.code, 2);
    EXPECT_NE(answer.err.find("broken.items"), std::string::npos) << answer.err;
    fs::remove(file("run/job.items"));
    answer = run({"check", trace, "--json"});
    EXPECT_EQ(answer.code, 0);
    EXPECT_EQ(Json::parse(answer.out)["pulses"], nullptr);
    EXPECT_EQ(run({"check", trace, "--pulses", file("run/pulses.trace")}).code, 2) << "asked for, but no items";
}

TEST_F(Check, TheMainJobKeepsItsLimits) {
    const Answer job = run({"scribe", "--out", file("run")});
    ASSERT_EQ(job.code, 0) << job.err;
    const std::string trace = file("run/samples.trace");
    Answer answer = run({"check", trace, "--json"});
    EXPECT_EQ(answer.code, 0) << answer.err << answer.out;
    const Json json = Json::parse(answer.out);
    EXPECT_EQ(json["passed"], true);
    EXPECT_EQ(json["limit_violations"], 0);
    EXPECT_LE(json["max_limit_ratio"].get<double>(), 1.005);
    EXPECT_GT(json["max_limit_ratio"].get<double>(), 0.9) << "the job does not move";
    EXPECT_EQ(json["axes"].size(), 6U) << "four axes and two mirrors";
    const auto ticks = json["ticks"].get<int>();
    EXPECT_GT(ticks, 10'000);

    EXPECT_GT(json["pulses"]["pulses"].get<int>(), 20'000);
    EXPECT_EQ(json["pulses"]["lost"], 0);
    EXPECT_EQ(json["pulses"]["violations"], 0);

    // The same trace is judged by the limits that are given: each of them must bite.
    for (const auto& [option, limits] :
         std::vector<std::pair<std::string, std::string>>{{"--limits", "0.198,5,200"},
                                                          {"--limits", "0.2,4.95,200"},
                                                          {"--limits", "0.2,5,198"},
                                                          {"--c-limits", "44.5,180,1800"},
                                                          {"--c-limits", "45,178,1800"},
                                                          {"--c-limits", "45,180,1780"}}) {
        EXPECT_EQ(run({"check", trace, option, limits}).code, 1) << option << limits;
    }
    EXPECT_EQ(run({"check", trace, "--keep-out", "-0.3,-0.3,-0.3,-0.1,-0.1,-0.1"}).code, 1);

    answer = run({"plot", trace, "-o", file("run.svg")});
    EXPECT_EQ(answer.code, 0) << answer.err;
    const std::string svg = read_file(folder_ / "run.svg");
    EXPECT_NE(svg.find("speed of C"), std::string::npos);
    EXPECT_EQ(svg.find("class=\"brokendot\""), std::string::npos);
    EXPECT_LT(svg.size(), 1'000'000U);

    // Homing is led by the drives; a single motion is not to be had of it.
    answer = run({"check", trace, "--ticks", "500:700"});
    EXPECT_EQ(answer.code, 2);
    EXPECT_NE(answer.err.find("the drives lead"), std::string::npos) << answer.err;
    answer = run({"check", trace, "--path", trace});
    EXPECT_EQ(answer.code, 2);
    EXPECT_NE(answer.err.find("--ticks"), std::string::npos) << answer.err;
    EXPECT_EQ(run({"check", trace, "--ticks", "0:" + std::to_string(ticks)}).code, 2) << "one tick too many";

    // Cut off within a move of the axes: the last set-points still move.
    const std::string bytes = read_file(trace);
    write_file(folder_ / "cut", bytes.substr(0, bytes.size() - 5));
    answer = run({"check", file("cut")});
    EXPECT_EQ(answer.code, 2);
    EXPECT_NE(answer.err.find("byte offset"), std::string::npos) << answer.err;
}

TEST_F(Check, AMotionInCsvPassesAndOnePerCentMoreDoesNot) {
    write_file(folder_ / "good.csv", motion_csv(1.0));
    write_file(folder_ / "bad.csv", motion_csv(1.01));
    write_file(folder_ / "path.csv", "x,y,z\n0,0,0\n3.2,0,0\n3.2,3.2,0\n");
    Answer answer = run({"check", file("good.csv"), "--path", file("path.csv"), "--path-speed", "0.2", "--json"});
    EXPECT_EQ(answer.code, 0) << answer.err << answer.out;
    Json json = Json::parse(answer.out);
    EXPECT_EQ(json["path"]["followed"], true);
    EXPECT_LE(json["path"]["max_deviation_um"].get<double>(), 0.001);
    EXPECT_NEAR(json["axes"]["x"]["jerk"]["ratio"].get<double>(), 1.0, 1e-3);
    EXPECT_NEAR(json["axes"]["c"]["jerk"]["ratio"].get<double>(), 1.0, 5e-3);

    answer = run({"check", file("bad.csv"), "--json"});
    EXPECT_EQ(answer.code, 1);
    json = Json::parse(answer.out);
    EXPECT_EQ(json["passed"], false);
    EXPECT_EQ(json["violations"][0]["rule"], "jerk");
    EXPECT_EQ(json["violations"][0]["axis"], "x");
    EXPECT_EQ(run({"check", file("bad.csv"), "--allow", "1.02"}).code, 0);
    answer = run({"check", file("bad.csv")});
    EXPECT_NE(answer.out.find("jerk of x 202"), std::string::npos) << answer.out;
    answer = run({"plot", file("bad.csv"), "--path", file("path.csv"), "--json"});
    EXPECT_EQ(answer.code, 0) << "drawn";
    EXPECT_EQ(Json::parse(answer.out)["passed"], false);
    EXPECT_NE(read_file(folder_ / "bad.csv.svg").find("class=\"brokendot\""), std::string::npos);
}

TEST_F(Check, DeviationIsHeldToTheTolerance) {
    write_file(folder_ / "path.csv", "x,y,z\n0,0,0\n3.2,0,0\n3.2,3.2,0\n");
    write_file(folder_ / "bent.csv", motion_csv(1.0, 5.0));
    const auto check = [&](const char* tolerance) {
        return run({"check", file("bent.csv"), "--path", file("path.csv"), "--tolerance", tolerance, "--json"});
    };
    write_file(folder_ / "vertex.csv", "x,y,z\n0,0,0\n1.6,0,0\n3.2,0,0\n3.2,3.2,0\n");
    for (const auto& [tolerance, code] : {std::pair{"0.0051", 0}, std::pair{"0.004", 1}}) {
        EXPECT_EQ(run({"check", file("bent.csv"), "--path", file("vertex.csv"), "--vertex-tolerance", tolerance}).code,
                  code);
    }
    EXPECT_EQ(run({"check", file("bent.csv"), "--path", file("path.csv"), "--may-return"}).code, 0);
    EXPECT_EQ(check("0.00501").code, 0) << check("0.00501").out;
    const Answer answer = check("0.0049");
    EXPECT_EQ(answer.code, 1);
    EXPECT_EQ(Json::parse(answer.out)["violations"][0]["rule"], "deviation");
    write_file(folder_ / "longer.csv", "x,y,z\n0,0,0\n3.2,0,0\n3.2,3.3,0\n");
    EXPECT_EQ(run({"check", file("bent.csv"), "--path", file("longer.csv")}).code, 1);
}

TEST_F(Check, BadInputNamesFileLineAndValue) {
    write_file(folder_ / "gap.csv", "t_s,x_m,y_m,z_m\n0,0,0,0\n0.002,0,0,0\n");
    Answer answer = run({"check", file("gap.csv"), "--json"});
    EXPECT_EQ(answer.code, 2);
    const Json error = Json::parse(answer.out)["error"];
    EXPECT_EQ(error["file"], file("gap.csv"));
    EXPECT_EQ(error["line"], 3);
    EXPECT_EQ(error["value"], "0.002");
    EXPECT_NE(error["action"], "");
    write_file(folder_ / "good.csv", motion_csv(1.0));
    const std::vector<std::vector<std::string>> wrong{
        {"--limits", "0.2,5"},
        {"--limits", "0.2,5,0"},
        {"--limits", "0.2,5,x"},
        {"--c-limits", "45,180,-1"},
        {"--tolerance", "0"},
        {"--vertex-tolerance", "-1"},
        {"--allow", "0.9"},
        {"--ticks", "5"},
        {"--ticks", "10:5"},
        {"--ticks", "0:201"},
        {"--keep-out", "1,1,1,0,2,2"},
        {"--travel", "0,1"},
        {"--path", file("none.csv")},
        {"--path-speed", "0"},
        {"--path", file("good.csv")},
        {"--no-such-option"},
    };
    for (const std::vector<std::string>& options : wrong) {
        for (const char* command : {"check", "plot"}) {
            std::vector<std::string> arguments{command, file("good.csv")};
            arguments.insert(arguments.end(), options.begin(), options.end());
            answer = run(arguments);
            EXPECT_EQ(answer.code, 2) << options[0];
            EXPECT_FALSE(answer.err.empty()) << options[0];
        }
    }
    EXPECT_FALSE(fs::exists(folder_ / "good.csv.svg")) << "nothing was to be drawn";
    EXPECT_EQ(run({"check"}).code, 2);
    EXPECT_EQ(run({"check", file("none")}).code, 2);
    EXPECT_EQ(run({"plot", file("good.csv"), "-o", file("no/folder.svg")}).code, 2);
    answer = run({"check", "--help"});
    EXPECT_EQ(answer.code, 0);
    EXPECT_NE(answer.out.find("Examples:"), std::string::npos);
}

}  // namespace
}  // namespace sc::test
