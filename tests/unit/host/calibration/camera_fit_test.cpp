// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "host/calibration/board_pose.hpp"
#include "host/calibration/stereo_fit.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr double kNoise = 0.1;
constexpr double kPitch = 0.025;

/// A camera with k1 alone, written out by hand.
struct True {
    double focal = 1100.0;
    double middle_x = 640.0;
    double middle_y = 480.0;
    double k1 = -0.2;
    [[nodiscard]] Pixel see(const Vec3& p) const {
        const double x = p.x / p.z;
        const double y = p.y / p.z;
        const double s = 1.0 + k1 * (x * x + y * y);
        return {focal * x * s + middle_x, focal * y * s + middle_y};
    }
};

Mat3 about(double x, double y, double z) {
    const Mat3 a{{Vec3{1.0, 0.0, 0.0}, Vec3{0.0, std::cos(x), -std::sin(x)}, Vec3{0.0, std::sin(x), std::cos(x)}}};
    const Mat3 b{{Vec3{std::cos(y), 0.0, std::sin(y)}, Vec3{0.0, 1.0, 0.0}, Vec3{-std::sin(y), 0.0, std::cos(y)}}};
    const Mat3 c{{Vec3{std::cos(z), -std::sin(z), 0.0}, Vec3{std::sin(z), std::cos(z), 0.0}, Vec3{0.0, 0.0, 1.0}}};
    return c * b * a;
}

struct Board {
    Mat3 rotation;
    Vec3 place;
};

std::vector<Board> boards(int count, double tilt, unsigned seed = 7) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> even(-1.0, 1.0);
    std::vector<Board> out;
    for (int i = 0; i < count; ++i) {
        Board board;
        board.rotation = about(tilt * even(random), tilt * even(random), 0.3 * even(random));
        const double z = 0.45 + 0.08 * even(random);
        board.place =
            Vec3{0.12 * even(random), 0.09 * even(random), z} - board.rotation * Vec3{4.0 * kPitch, 2.5 * kPitch, 0.0};
        out.push_back(board);
    }
    return out;
}

using Carry = std::function<Vec3(const Vec3&)>;

std::vector<BoardView> views_of(const std::vector<Board>& all, const True& camera, const Carry& carry, unsigned seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise(0.0, kNoise);
    std::vector<BoardView> out;
    for (std::size_t i = 0; i < all.size(); ++i) {
        BoardView view{.name = std::to_string(i + 1), .width = 1281, .height = 961, .points = {}};
        for (int row = 0; row < 6; ++row) {
            for (int column = 0; column < 9; ++column) {
                const Vec3 place{kPitch * column, kPitch * row, 0.0};
                const Pixel at = camera.see(carry(all[i].rotation * place + all[i].place));
                view.points.push_back({.line = 0,
                                       .column = column,
                                       .row = row,
                                       .place = place,
                                       .seen = {at[0] + noise(random), at[1] + noise(random)}});
            }
        }
        out.push_back(view);
    }
    return out;
}

Vec3 stay(const Vec3& p) { return p; }
const Mat3 kTurn = about(0.01, 0.2, -0.015);
Vec3 to_right(const Vec3& p) { return kTurn * p + Vec3{-0.11, 0.002, 0.012}; }

TEST(CameraFit, FindsTheCameraWithinItsStatedSigma) {
    const True truth;
    const CameraFit fit = fit_camera("f", views_of(boards(12, 0.6), truth, stay, 1));
    const CameraModel& m = fit.camera.model;
    EXPECT_NEAR(fit.noise, kNoise, 0.006);
    EXPECT_NEAR(m.focal_x, truth.focal, 4.0 * fit.sigma[0]);
    EXPECT_NEAR(m.focal_y, truth.focal, 4.0 * fit.sigma[1]);
    EXPECT_NEAR(m.middle_x, truth.middle_x, 4.0 * fit.sigma[2]);
    EXPECT_NEAR(m.middle_y, truth.middle_y, 4.0 * fit.sigma[3]);
    EXPECT_NEAR(m.distortion[0], truth.k1, 4.0 * fit.sigma[4]);
    EXPECT_LT(fit.sigma[0], 1.5);
    EXPECT_TRUE(fit.wrong.empty());
    EXPECT_TRUE(fit.camera.fixed.empty());
}

TEST(CameraFit, NamesSwappedAndWrongPointsAndABadPicture) {
    auto views = views_of(boards(12, 0.6), True{}, stay, 2);
    std::swap(views[2].points[10].seen, views[2].points[11].seen);  // columns 1 and 2 of row 1
    views[5].points[20].seen[0] += 6.0;                             // column 2 of row 2
    for (BoardPoint& p : views[8].points) {                         // of another board
        p.place.x *= 1.2;
    }
    const CameraFit fit = fit_camera("f", views);
    ASSERT_EQ(fit.wrong.size(), 3U);
    EXPECT_EQ(fit.wrong[0].view, "3");
    EXPECT_EQ(fit.wrong[0].swapped, (std::array{2, 1}));
    EXPECT_EQ(fit.wrong[1].swapped, (std::array{1, 1}));
    EXPECT_EQ(fit.wrong[2].view, "6");
    EXPECT_FALSE(fit.wrong[2].swapped);
    EXPECT_NEAR(fit.wrong[2].off, 6.0, 0.5);
    EXPECT_FALSE(fit.views[8].used);
    EXPECT_NEAR(fit.camera.model.focal_x, True{}.focal, 4.0 * fit.sigma[0]);
}

void expect_refused(const std::vector<BoardView>& views, const char* words) {
    try {
        static_cast<void>(fit_camera("left.csv", views));
        FAIL() << "not refused: " << words;
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
}

TEST(CameraFit, RefusesWhatCannotShowTheCamera) {
    expect_refused(views_of(boards(2, 0.6), True{}, stay, 3), "too few views");
    expect_refused(views_of(boards(10, 0.004), True{}, stay, 3), "parallel to the picture plane");
    auto unsized = views_of(boards(5, 0.6), True{}, stay, 3);
    unsized[1].width = 0;
    expect_refused(unsized, "size");
}

TEST(CameraFit, FixesAndNamesWhatIsBlind) {
    // One small board in the middle of the picture: the distortion's high orders move nothing there.
    std::vector<Board> few = boards(4, 0.6);
    for (Board& b : few) {
        b.place = b.place + Vec3{0.0, 0.0, 1.2};
    }
    const CameraFit fit = fit_camera("f", views_of(few, True{}, stay, 4));
    EXPECT_FALSE(fit.notes.empty());
    const CameraFit held = fit_camera("f", views_of(boards(8, 0.6), True{}, stay, 4), {.fixed = {"k3", "p1", "p2"}});
    EXPECT_EQ(held.camera.fixed, (std::vector<std::string>{"p1", "p2", "k3"}));
    EXPECT_EQ(held.camera.model.distortion[4], 0.0);
    EXPECT_EQ(held.sigma[8], 0.0);
}

TEST(StereoFit, FindsThePairAndWhatAPlaceComesTo) {
    const auto all = boards(12, 0.6);
    const StereoFit fit =
        fit_stereo("l", views_of(all, True{}, stay, 5), "r", views_of(all, True{.focal = 1080.0}, to_right, 6));
    const Vec3 t = fit.set.right_from_left->translation;
    EXPECT_NEAR(t.x, -0.11, 4.0 * fit.pose_sigma[3]);
    EXPECT_NEAR(t.y, 0.002, 4.0 * fit.pose_sigma[4]);
    EXPECT_NEAR(t.z, 0.012, 4.0 * fit.pose_sigma[5]);
    EXPECT_NEAR(fit.baseline, norm(Vec3{-0.11, 0.002, 0.012}), 4.0 * fit.baseline_sigma);
    EXPECT_NEAR(fit.rms, kNoise, 0.005);
    EXPECT_NEAR(fit.epipolar_rms, kNoise * std::sqrt(2.0), 0.02);
    EXPECT_NEAR(fit.expected.distance, 0.45, 0.05);
    EXPECT_GT(fit.expected.noise.z, fit.expected.noise.x);
    EXPECT_EQ(fit.boards.size(), 12U);
    EXPECT_LT(std::abs(fit.boards.front().scale), 2e-3);
}

TEST(StereoFit, NamesAPairThatDoesNotBelongTogether) {
    const auto all = boards(10, 0.6);
    auto right = views_of(all, True{}, to_right, 6);
    std::swap(right[3].points, right[4].points);
    const StereoFit fit = fit_stereo("l", views_of(all, True{}, stay, 5), "r", right);
    EXPECT_FALSE(fit.views[3].used && fit.views[4].used);
    bool named = false;
    for (const std::string& note : fit.notes) {
        named = named || note.find("do not belong together") != std::string::npos;
    }
    EXPECT_TRUE(named);
    EXPECT_NEAR(fit.set.right_from_left->translation.x, -0.11, 4.0 * fit.pose_sigma[3]);
    EXPECT_THROW(static_cast<void>(fit_stereo("l", views_of(boards(10, 0.6, 1), True{}, stay, 5), "r",
                                              views_of(boards(10, 0.6, 2), True{}, to_right, 6))),
                 InputError);
}

TEST(BoardPose, IsWhereTheBoardStands) {
    const auto all = boards(4, 0.6);
    const CameraModel camera{.focal_x = 1100.0,
                             .focal_y = 1100.0,
                             .middle_x = 640.0,
                             .middle_y = 480.0,
                             .distortion = {-0.2, 0.0, 0.0, 0.0, 0.0}};
    const BoardPoses found = find_board_poses("f", views_of(all, True{}, stay, 9), camera);
    ASSERT_EQ(found.poses.size(), 4U);
    for (std::size_t i = 0; i < all.size(); ++i) {
        const ViewFit& view = found.poses[i].fit;
        EXPECT_NEAR(view.translation.x, all[i].place.x, 4.5 * view.sigma[3]);
        EXPECT_NEAR(view.translation.y, all[i].place.y, 4.5 * view.sigma[4]);
        EXPECT_NEAR(view.translation.z, all[i].place.z, 4.5 * view.sigma[5]);
        EXPECT_LT(view.sigma[5], 5e-4);
    }
}

}  // namespace
}  // namespace sc::host
