// SPDX-License-Identifier: Apache-2.0
#include "host/formats/cameras.hpp"

#include <filesystem>

#include <gtest/gtest.h>
#include <unistd.h>

#include "host/formats/board_points.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"

namespace sc::host {
namespace {

class Cameras : public testing::Test {
protected:
    void SetUp() override {
        file_ = std::filesystem::path(testing::TempDir()) / ("sc_cameras_" + std::to_string(::getpid()));
    }
    void TearDown() override { std::filesystem::remove(file_); }

    template <class Work>
    void expect_refused(const Work& work, const std::string& words, int line) {
        try {
            work();
            FAIL() << "not refused: " << words;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
            EXPECT_EQ(error.line(), line) << error.what();
        }
    }

    std::filesystem::path file_;
};

CameraSet pair() {
    CameraSet out{.id = "pair",
                  .time = "2026-01-02T03:04:05Z",
                  .parents = {"left.csv", "right.csv"},
                  .noise = 0.135,
                  .cameras = {},
                  .right_from_left = CameraSet::Pose{.rotation = {}, .translation = {-0.0831, 0.0009, 1e-4}},
                  .covariance = std::vector<std::vector<double>>(24, std::vector<double>(24, 0.0))};
    CameraRecord camera{
        .id = "left", .width = 640, .height = 480, .model = {}, .fixed = {"k3"}, .rms = 0.13, .reach = 0.7};
    camera.model = {.focal_x = 534.1,
                    .focal_y = 534.2,
                    .middle_x = 341.0,
                    .middle_y = 236.0,
                    .distortion = {-0.297, 0.15, 0.001, -0.0002, 0.0}};
    out.cameras = {camera, camera};
    out.cameras[1].id = "right";
    for (std::size_t i = 0; i < 24; ++i) {
        out.covariance[i][i] = 1e-4 * static_cast<double>(i + 1);
    }
    return out;
}

TEST_F(Cameras, ComeBackAsTheyWereWritten) {
    write_cameras(file_, pair());
    EXPECT_EQ(read_cameras(file_), pair());
    CameraSet one = pair();
    one.cameras.pop_back();
    one.right_from_left.reset();
    one.covariance.clear();
    write_cameras(file_, one);
    EXPECT_EQ(read_cameras(file_), one);
}

TEST_F(Cameras, RefusesWhatIsNoPair) {
    CameraSet three = pair();
    three.cameras.push_back(three.cameras[0]);
    EXPECT_THROW(write_cameras(file_, three), InputError);
    CameraSet together = pair();
    together.right_from_left->translation = {};
    EXPECT_THROW(write_cameras(file_, together), InputError);
    CameraSet mirrored = pair();
    mirrored.right_from_left->rotation.row[2].z = -1.0;
    EXPECT_THROW(write_cameras(file_, mirrored), InputError);
    CameraSet flat = pair();
    flat.cameras[0].model.focal_x = 0.0;
    EXPECT_THROW(write_cameras(file_, flat), InputError);
    EXPECT_FALSE(std::filesystem::exists(file_));
}

TEST_F(Cameras, BoardPointsAreReadInAnyUnitAndNamedWhereTheyAreBad) {
    write_text_file(file_, "view,row,col,X_mm,Y_mm,u_px,v_px\n1,0,2,25.4,0,10.5,20\n");
    const auto rows = read_board_points(file_);
    ASSERT_EQ(rows.size(), 1U);
    EXPECT_EQ(rows[0].column, 2);
    EXPECT_EQ(rows[0].line, 2);
    EXPECT_DOUBLE_EQ(rows[0].place->x, 0.0254);
    write_text_file(file_, "view,row,col,X,Y,u_px,v_px\n1,0,2,1,0,10.5,20\n");
    EXPECT_DOUBLE_EQ(read_board_points(file_, "inch")[0].place->x, 0.0254);
    const auto read = [&] { static_cast<void>(read_board_points(file_)); };
    expect_refused(read, "without a unit", 1);
    write_text_file(file_, "view,row,col,u_px,v_px\n1,0,2,10.5,20\n1,0,2,11,20\n");
    expect_refused(read, "twice", 3);
    write_text_file(file_, "view,row,col,X_mm,Y_m,u_px,v_px\n1,0,2,1,0,10.5,20\n");
    expect_refused(read, "different units", 1);
    write_text_file(file_, "view,row,col,u_px,v_px,sigma_px\n1,0,2,10.5,20,-1\n");
    expect_refused(read, "below zero", 2);
    write_text_file(file_, "view,row,col,u_px,v_px,weight\n1,0,2,10.5,20,1\n");
    expect_refused(read, "unknown column", 1);
}

}  // namespace
}  // namespace sc::host
