// SPDX-License-Identifier: Apache-2.0
// Cameras and pairs by the commands, as a person runs them: real pictures, and sets of scribecell-rig and -circles.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
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

std::vector<std::vector<std::string>> rows_of(const fs::path& file) {
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);
    std::vector<std::vector<std::string>> out;
    while (std::getline(in, line)) {
        std::stringstream cells(line);
        out.emplace_back();
        for (std::string cell; std::getline(cells, cell, ',');) {
            out.back().push_back(cell);
        }
    }
    return out;
}

class Cameras : public testing::Test {
protected:
    void SetUp() override {
        folder_ = fs::path(::testing::TempDir()) / ("scribecell_cameras_" + std::to_string(::getpid()));
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    [[nodiscard]] std::string at(const std::string& name) const { return (folder_ / name).string(); }

    fs::path folder_;
};

const std::string kData = SC_TEST_DATA;

TEST_F(Cameras, ARealPairIsAsGoodAsItsKnownCalibration) {
    const Ended ended = run({"calibrate", "stereo", "--left", kData + "/stereo-chessboard/left0*.jpg", "--right",
                             kData + "/stereo-chessboard/right0*.jpg", "--board", "9x6", "--square", "25", "--out",
                             at("pair.toml"), "--overlays", at("drawn"), "--json"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const json fit = json::parse(ended.out);
    // What is known of the set (its README): 0.22 px, a base line of 83.2 mm, corners 0.25 to 0.67 mm off the board.
    EXPECT_LT(fit.at("rms_px").get<double>(), 0.20);
    EXPECT_LT(fit.at("epipolar_rms_px").get<double>(), 0.20);
    EXPECT_NEAR(fit.at("baseline_mm").get<double>(), 83.2, 0.3);
    EXPECT_NEAR(fit.at("left").at("fx_px").get<double>(), 534.0, 3.0);
    ASSERT_EQ(fit.at("boards").size(), 9U);
    std::vector<double> rms;
    for (const json& board : fit.at("boards")) {
        rms.push_back(board.at("rms_mm").get<double>());
    }
    std::ranges::sort(rms);
    EXPECT_LT(rms[4], 0.33);
    EXPECT_LT(rms.back(), 0.67);
    EXPECT_TRUE(fs::exists(at("drawn/left_01.svg")));
    EXPECT_TRUE(fs::exists(at("drawn/right_09.svg")));
    // The file is one that other commands take.
    const Ended pose = run({"vision", "board", "--pictures", kData + "/stereo-chessboard/left03.jpg", "--board", "9x6",
                            "--square", "25", "--camera", at("pair.toml"), "--id", "left", "--json"});
    ASSERT_EQ(pose.code, 0) << pose.err;
    EXPECT_NEAR(json::parse(pose.out).at("views")[0].at("translation_mm")[2].get<double>(), 316.6, 3.0);
}

TEST_F(Cameras, ARealPairAgreesWithOpenCvOnTheSamePoints) {
    const std::string peer = std::string(SC_BINARY_DIR) + "/bin/scribecell-stereo-peer";
    if (!fs::exists(peer)) {
        GTEST_SKIP() << "OpenCV's calib3d was not there at build time";
    }
    const Ended ended = run({"calibrate", "stereo", "--left", kData + "/stereo-chessboard/left0*.jpg", "--right",
                             kData + "/stereo-chessboard/right0*.jpg", "--board", "9x6", "--square", "25", "--points",
                             at("set_0001"), "--keep-all", "--json"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const json fit = json::parse(ended.out);
    ASSERT_EQ(run({folder_.string(), "--size", "640x480"}, "scribecell-stereo-peer").code, 0);
    const auto row = rows_of(at("opencv.csv")).at(0);
    EXPECT_LE(fit.at("rms_px").get<double>(), std::stod(row.at(1)) * 1.00001);
    const std::array<const char*, 4> names{"fx_px", "fy_px", "cx_px", "cy_px"};
    for (std::size_t camera = 0; camera < 2; ++camera) {
        const json& ours = fit.at(camera == 0 ? "left" : "right");
        for (std::size_t k = 0; k < 9; ++k) {
            const double value =
                k < 4 ? ours.at(names[k]).get<double>() : ours.at("k1_k2_p1_p2_k3")[k - 4].get<double>();
            EXPECT_NEAR(value, std::stod(row.at(2 + 9 * camera + k)), 0.1 * ours.at("sigma")[k].get<double>())
                << camera << " " << k;
        }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(fit.at("right_from_left").at("translation_mm")[axis].get<double>(), std::stod(row.at(20 + axis)),
                    1e-4 * fit.at("right_from_left").at("sigma_translation_um")[axis].get<double>());
    }
}

TEST_F(Cameras, MismatchedListsAndPicturesWithoutABoardAreNamed) {
    const Ended none =
        run({"calibrate", "camera", "--pictures", kData + "/laser-spots/*.png", "--board", "9x6", "--square", "25"});
    EXPECT_EQ(none.code, 2);
    const Ended no_square = run({"calibrate", "stereo", "--left", kData + "/stereo-chessboard/left0*.jpg", "--right",
                                 kData + "/stereo-chessboard/right0*.jpg", "--board", "9x6"});
    EXPECT_EQ(no_square.code, 2);
    EXPECT_NE(no_square.err.find("--square"), std::string::npos);
    const Ended two = run({"calibrate", "stereo", "--left", kData + "/stereo-chessboard/left0[12].jpg", "--right",
                           kData + "/stereo-chessboard/right0*.jpg", "--board", "9x6", "--square", "25"});
    EXPECT_EQ(two.code, 2);
    EXPECT_FALSE(fs::exists(at("pair.toml")));
}

TEST_F(Cameras, ARealRobotSetIsNoWorseThanTheBestMethodsThatAreKnown) {
    const std::string set = kData + "/handeye-circlegrid/";
    const auto scatter = [&](const std::vector<std::string>& camera) {
        std::vector<std::string> words{"vision", "board",   "--pictures", set + "centres_px.csv",
                                       "--size", "640x480", "--out",      at("poses.csv")};
        words.insert(words.end(), camera.begin(), camera.end());
        const Ended board = run(words);
        EXPECT_EQ(board.code, 0) << board.err;
        const Ended eye = run({"calibrate", "hand-eye", "--robot-poses", set + "robot_poses.csv", "--target",
                               at("poses.csv"), "--fit-noise", "--most-mm", "20", "--most-deg", "2", "--json"});
        EXPECT_EQ(eye.code, 0) << eye.err;
        return eye.code == 0 ? json::parse(eye.out).at("scatter_rms_mm").get<double>() : 1e9;
    };
    // With the nominal camera closed forms scatter the target by 17 to 18.5 mm.
    EXPECT_LT(scatter({"--pinhole", "550,550,320,240"}), 17.0);
    const Ended camera = run({"calibrate", "camera", "--pictures", set + "centres_px.csv", "--size", "640x480", "--out",
                              at("camera.toml"), "--json"});
    ASSERT_EQ(camera.code, 0) << camera.err;
    EXPECT_LT(json::parse(camera.out).at("camera").at("rms_px").get<double>(), 0.2);
    EXPECT_LT(scatter({"--camera", at("camera.toml")}), 7.0);
}

TEST_F(Cameras, MarkersOfATargetAreWhereTheyTrulyAre) {
    ASSERT_EQ(run({"pairs", "--out", folder_.string(), "--scenes", "2", "--repeats", "1", "--seed", "5"},
                  "scribecell-circles")
                  .code,
              0);
    std::map<std::string, std::map<int, std::vector<double>>> truth;
    for (const auto& row : rows_of(at("truth.csv"))) {
        truth[row.at(0)][std::stoi(row.at(1))] = {std::stod(row.at(2)), std::stod(row.at(3)), std::stod(row.at(4))};
    }
    double squares = 0.0;
    double plain = 0.0;
    double over_sigma = 0.0;
    double count = 0.0;
    for (const std::string scene : {"0", "1"}) {
        std::vector<std::string> words{"vision",        "stereo",
                                       "--left",        at("left_0" + scene + "_00.png"),
                                       "--right",       at("right_0" + scene + "_00.png"),
                                       "--calibration", at("pair.toml"),
                                       "--target",      at("target.toml"),
                                       "--view",        "v",
                                       "--out",         at("cloud.csv"),
                                       "--json"};
        const Ended ended = run(words);
        ASSERT_EQ(ended.code, 0) << ended.out << ended.err;
        const json found = json::parse(ended.out);
        // Two are covered and three are strangers; one more may lie behind another in one picture.
        EXPECT_GE(found.at("markers").size(), 17U);
        EXPECT_EQ(found.at("markers").size() + found.at("missing").size(), 20U);
        EXPECT_GE(found.at("not_of_the_target").get<int>(), 2);
        EXPECT_NEAR(found.at("radius_mm").get<double>(), 3.0, 0.02);
        words.push_back("--uncorrected");
        const json bare = json::parse(run(words).out);
        for (const json& m : found.at("markers")) {
            const auto& place = truth.at(scene).at(m.at("id").get<int>());
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double off = m.at("place_mm")[axis].get<double>() - place[axis];
                squares += off * off;
                over_sigma += std::pow(1e3 * off / m.at("sigma_um")[axis].get<double>(), 2);
                count += 1.0;
            }
        }
        for (const json& m : bare.at("markers")) {
            const auto& place = truth.at(scene).at(m.at("id").get<int>());
            for (std::size_t axis = 0; axis < 3; ++axis) {
                plain += std::pow(m.at("place_mm")[axis].get<double>() - place[axis], 2);
            }
        }
    }
    const double rms_um = 1e3 * std::sqrt(squares / count);
    EXPECT_LT(rms_um, 6.0);
    EXPECT_GT(1e3 * std::sqrt(plain / count), 1.5 * rms_um);  // perspective left in
    EXPECT_LT(std::sqrt(over_sigma / count), 1.6);
    EXPECT_GE(rows_of(at("cloud.csv")).size(), 17U);
}

TEST_F(Cameras, SimulatedPairsAreWithinTheirSigmaAndSwapsAreNamed) {
    ASSERT_EQ(run({"stereo", "--out", folder_.string(), "--sets", "1", "--swapped-views", "2", "--seed", "9"},
                  "scribecell-rig")
                  .code,
              0);
    const Ended ended = run({"calibrate", "stereo", "--left", at("set_0001/left.csv"), "--right",
                             at("set_0001/right.csv"), "--size", "1280x960", "--json"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const json fit = json::parse(ended.out);
    EXPECT_NEAR(fit.at("noise_px").get<double>(), 0.1, 0.008);
    EXPECT_EQ(fit.at("wrong_points").size(), 4U);
    for (const json& wrong : fit.at("wrong_points")) {
        EXPECT_TRUE(wrong.contains("swapped_with")) << wrong;
    }
    const auto row = rows_of(at("truth.csv")).at(0);
    EXPECT_NEAR(fit.at("left").at("fx_px").get<double>(), std::stod(row.at(1)),
                4.0 * fit.at("left").at("sigma")[0].get<double>());
    EXPECT_NEAR(fit.at("right_from_left").at("translation_mm")[0].get<double>(), std::stod(row.at(19)),
                4e-3 * fit.at("right_from_left").at("sigma_translation_um")[0].get<double>());
    // All views flat before the cameras: the focal length is blind.
    ASSERT_EQ(run({"stereo", "--out", at("flat"), "--tilt-deg", "0.2"}, "scribecell-rig").code, 0);
    const Ended flat = run({"calibrate", "camera", "--pictures", at("flat/set_0001/left.csv"), "--size", "1280x960"});
    EXPECT_EQ(flat.code, 2);
    EXPECT_NE(flat.err.find("focal length"), std::string::npos) << flat.err;
}

}  // namespace
}  // namespace sc::test
