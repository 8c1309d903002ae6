// SPDX-License-Identifier: Apache-2.0
// Circular markers by the commands, as a person runs them, on pictures of scribecell-circles.
#include <cmath>
#include <filesystem>
#include <fstream>
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

struct Place {
    double x;
    double y;
};

class Board : public testing::Test {
protected:
    void SetUp() override {
        folder_ = fs::path(::testing::TempDir()) / ("scribecell_markers_" + std::to_string(::getpid()));
        fs::remove_all(folder_);
        ASSERT_EQ(run({"boards", "--out", folder_.string(), "--scenes", "1", "--repeats", "1", "--seed", "4"},
                      "scribecell-circles")
                      .code,
                  0);
        std::ifstream truth(at("truth.csv"));
        std::string line;
        std::getline(truth, line);
        while (std::getline(truth, line)) {
            std::stringstream cells(line);
            std::vector<std::string> row;
            for (std::string cell; std::getline(cells, cell, ',');) {
                row.push_back(cell);
            }
            centres_.push_back({std::stod(row.at(4)), std::stod(row.at(5))});
        }
        ASSERT_EQ(centres_.size(), 5U);
    }
    void TearDown() override { fs::remove_all(folder_); }

    [[nodiscard]] std::string at(const std::string& name) const { return (folder_ / name).string(); }
    [[nodiscard]] double off(double x, double y) const {
        double least = 1e9;
        for (const Place& p : centres_) {
            least = std::min(least, std::hypot(p.x - x, p.y - y));
        }
        return least;
    }

    fs::path folder_;
    std::vector<Place> centres_;
};

TEST_F(Board, MiddlesOfCirclesAreWhereTheyTrulyAre) {
    const Ended ended = run({"vision", "markers", at("board_00_00.png"), "--camera", "2232,2232,239.5,239.5",
                             "--radius-mm", "5", "--json", "--svg", at("o.svg"), "--png", at("o.png")});
    ASSERT_EQ(ended.code, 0) << ended.out << ended.err;
    const json picture = json::parse(ended.out).at("pictures").at(0);
    ASSERT_EQ(picture.at("markers").size(), 5U);
    double uncorrected = 0.0;
    for (const json& m : picture.at("markers")) {
        EXPECT_LT(off(m.at("circle").at("x_px"), m.at("circle").at("y_px")), 0.04);
        uncorrected = std::max(uncorrected, off(m.at("x_px"), m.at("y_px")));
        const double z = m.at("circle").at("place_mm").at(2);
        EXPECT_NEAR(z, 500.0, 45.0);
    }
    EXPECT_GT(uncorrected, 0.08);
    EXPECT_NEAR(std::abs(picture.at("normal").at(2).get<double>()), std::sqrt(0.5), 0.01);
    EXPECT_GT(fs::file_size(at("o.svg")), 5000U);
    EXPECT_GT(fs::file_size(at("o.png")), 1000U);
}

TEST_F(Board, ClutterIsListedAndNoFailureAndCountsMayBeAskedFor) {
    const std::string real = std::string(SC_TEST_DATA) + "/circle-grid/0.png";
    const Ended ended = run({"vision", "markers", real, "--json"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    const json picture = json::parse(ended.out).at("pictures").at(0);
    EXPECT_GT(picture.at("refused").size(), 0U);
    const std::size_t count = picture.at("markers").size();
    EXPECT_EQ(run({"vision", "markers", real, "--expect", std::to_string(count)}).code, 0);
    const Ended more = run({"vision", "markers", real, "--expect", std::to_string(count + 1)});
    EXPECT_EQ(more.code, 1);
    EXPECT_NE(more.err.find("are expected"), std::string::npos) << more.err;
}

TEST_F(Board, WrongUsageSaysWhatToGive) {
    const std::string picture = at("board_00_00.png");
    const Ended no_camera = run({"vision", "markers", picture, "--radius-mm", "5"});
    EXPECT_EQ(no_camera.code, 2);
    EXPECT_NE(no_camera.err.find("--camera fx,fy,cx,cy"), std::string::npos) << no_camera.err;
    const Ended two = run({"vision", "markers", picture, picture, "--svg", at("o.svg")});
    EXPECT_EQ(two.code, 2);
    EXPECT_NE(two.err.find("one picture at a time"), std::string::npos) << two.err;
    EXPECT_EQ(run({"vision", "markers", at("none.png")}).code, 2);
    EXPECT_EQ(run({"vision", "markers", picture, "--camera", "0,0,1,1"}).code, 2);
}

}  // namespace
}  // namespace sc::test
