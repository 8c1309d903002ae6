// SPDX-License-Identifier: Apache-2.0
// Registration and the whole chain, as a person runs them, on the cells of scribecell-rig.
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "program.hpp"

namespace sc::test {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

struct Ended {
    int code;
    std::string out;
    std::string err;
};

Ended run(const std::vector<std::string>& arguments, const std::string& program = "scribecell") {
    Program p(program, arguments);
    const int code = p.wait();
    return {code, p.out(), p.err()};
}

class Chain : public testing::Test {
protected:
    void SetUp() override {
        folder_ = fs::path(::testing::TempDir()) / ("scribecell_chain_" + std::to_string(::getpid()));
        fs::remove_all(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    void make(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), "chain");
        arguments.insert(arguments.end(), {"--out", folder_.string()});
        ASSERT_EQ(run(arguments, "scribecell-rig").code, 0);
    }
    [[nodiscard]] std::string at(const std::string& name) const { return (folder_ / name).string(); }
    [[nodiscard]] std::string set(const std::string& name) const { return at("set_0001/" + name); }
    [[nodiscard]] std::vector<std::string> chain(const std::vector<std::string>& more) const {
        std::vector<std::string> out{"calibrate",  "chain",
                                     "--scan-set", set("scan_set.toml"),
                                     "--target",   set("references.toml"),
                                     "--target",   set("mobile.toml"),
                                     "--pointing", set("pointing.csv")};
        out.insert(out.end(), more.begin(), more.end());
        return out;
    }
    [[nodiscard]] static json json_of(std::vector<std::string> arguments) {
        arguments.emplace_back("--json");
        const Ended ended = run(arguments);
        EXPECT_EQ(ended.code, 0) << ended.out << ended.err;
        return json::parse(ended.out, nullptr, false);
    }
    [[nodiscard]] static std::string refusal(const std::vector<std::string>& arguments) {
        const Ended ended = run(arguments);
        EXPECT_EQ(ended.code, 2) << ended.out << ended.err;
        return ended.err;
    }
    /// Largest axis value, µm, between the places of a report and where the beam meets the marks.
    [[nodiscard]] double worst_um(const json& places) const {
        std::istringstream in(read_file(set("marks.csv")));
        std::string line;
        std::getline(in, line);
        double worst = 0.0;
        std::size_t row = 0;
        for (; std::getline(in, line); ++row) {
            std::istringstream fields(line);
            char comma = ',';
            double id = 0.0;
            double face = 0.0;
            std::vector<double> p(3);
            fields >> id >> comma >> face >> comma >> p[0] >> comma >> p[1] >> comma >> p[2];
            EXPECT_EQ(places[row]["id"].get<int>(), static_cast<int>(id));
            for (std::size_t k = 0; k < 3; ++k) {
                worst = std::max(worst, 1e3 * std::abs(places[row]["place_mm"][k].get<double>() - p[k]));
            }
        }
        EXPECT_EQ(places.size(), row);
        return worst;
    }
    void ask_for_marks() const {
        std::istringstream in(read_file(set("marks.csv")));
        std::string line;
        std::string asked;
        while (std::getline(in, line)) {
            asked += line.substr(0, line.find(',', line.find(',') + 1)) + "\n";
        }
        write_file(at("asked.csv"), asked);
    }

private:
    fs::path folder_;
};

TEST_F(Chain, MarksStandWhereItSaysAndTheSetServesOthers) {
    make({"--seed", "3"});
    ask_for_marks();
    const json object = json_of(chain({"--predict", at("asked.csv"), "--out", at("cell.toml"), "--map",
                                       at("ring_in_c.toml"), "--svg", at("map.svg")}));
    EXPECT_LT(worst_um(object["places"]), 60.0);
    EXPECT_TRUE(object["wrong"].empty()) << object["wrong"];
    EXPECT_NEAR(object["chi_squared"].get<double>() / object["freedom"].get<double>(), 1.0, 0.15);
    EXPECT_NEAR(object["robot_noise_ratio"].get<double>(), 1.0, 0.3);
    const std::string cell = read_file(at("cell.toml"));
    EXPECT_NE(cell.find("h_from_c"), std::string::npos);
    EXPECT_NE(cell.find("[turntable]"), std::string::npos) << cell;
    EXPECT_NE(cell.find("[[cross_covariance]]"), std::string::npos) << cell;
    EXPECT_NE(read_file(at("map.svg")).find("</svg>"), std::string::npos);

    // Later, the same scan is registered to the map of what stands still: the same marks, by the set's axis.
    const json later = json_of({"register", "--scan-set", set("scan_set.toml"), "--target", at("ring_in_c.toml"),
                                "--calibration", at("cell.toml"), "--out", at("stitched.toml")});
    EXPECT_EQ(later["markers"].size(), object["markers"].size());
    for (std::size_t i = 0; i < later["markers"].size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_NEAR(later["markers"][i]["place_mm"][k].get<double>(),
                        object["markers"][i]["place_mm"][k].get<double>(), 0.03);
        }
    }
    EXPECT_NE(read_file(at("stitched.toml")).find("id = \"stitched\""), std::string::npos);
}

TEST_F(Chain, ARobotThatIsOffDoesNoHarmAndIsNamed) {
    make({"--seed", "4", "--robot", "dh"});
    ask_for_marks();
    const json object = json_of(chain({"--predict", at("asked.csv")}));
    EXPECT_LT(worst_um(object["places"]), 60.0);
    EXPECT_GT(object["robot_noise_ratio"].get<double>(), 5.0);
    EXPECT_NE(object["notes"].dump().find("robot poses are off by"), std::string::npos) << object["notes"];
}

TEST_F(Chain, WhatIsWrongInTheViewsIsNamed) {
    make({"--seed", "5", "--wrong", "3", "--swapped", "1", "--wrong-angle-deg", "0.4"});
    ask_for_marks();
    const json object = json_of(chain({"--predict", at("asked.csv")}));
    std::istringstream in(read_file(set("wrong.csv")));
    std::string line;
    std::getline(in, line);
    const std::string named = object["wrong"].dump() + object["notes"].dump();
    int wrong = 0;
    while (std::getline(in, line)) {
        EXPECT_NE(named.find(line.substr(0, line.find(','))), std::string::npos) << line << "\n" << named;
        ++wrong;
    }
    EXPECT_EQ(wrong, 5);
    EXPECT_EQ(object["wrong"].size(), 4U) << object["wrong"];
    EXPECT_NE(object["notes"].dump().find("angle was read wrong, by 0.4"), std::string::npos) << object["notes"];
    EXPECT_LT(worst_um(object["places"]), 60.0);
}

TEST_F(Chain, CloudsAreStitchedWithTheTableAtZero) {
    make({"--seed", "6", "--clouds"});
    const json object = json_of({"register", "--scan-set", set("scan_set.toml"), "--target", set("references.toml"),
                                 "--target", set("mobile.toml"), "--out", at("stitched.toml")});
    EXPECT_EQ(object["points"].get<int>(), 1600);
    EXPECT_TRUE(fs::exists(at("stitched.ply")));
    EXPECT_NE(read_file(at("stitched.toml")).find("stitched.ply"), std::string::npos);
}

TEST_F(Chain, DataThatCannotSupportItAreRefusedByName) {
    make({"--seed", "7", "--angles", "3"});
    std::string text = refusal({"register", "--scan-set", set("scan_set.toml")});  // nothing said to stand still
    EXPECT_NE(text.find("in common"), std::string::npos) << text;
    text = refusal({"register", "--scan-set", set("nothing.toml")});
    EXPECT_NE(text.find("nothing.toml"), std::string::npos) << text;
    std::string rows = read_file(set("pointing.csv"));
    rows = rows.substr(0, rows.find('\n', rows.find("\n302,") + 1) + 1);
    write_file(set("pointing.csv"), rows);
    text = refusal(chain({"--out", at("cell.toml")}));
    EXPECT_NE(text.find("fewer than three"), std::string::npos) << text;
    EXPECT_NE(text.find("pointing.csv"), std::string::npos) << text;
    EXPECT_FALSE(fs::exists(at("cell.toml")));
}

}  // namespace
}  // namespace sc::test
