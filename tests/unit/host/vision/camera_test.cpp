// SPDX-License-Identifier: Apache-2.0
#include "host/vision/camera.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "host/vision/triangulation.hpp"

namespace sc::host {
namespace {

const CameraModel kBarrel{.focal_x = 534.0,
                          .focal_y = 536.0,
                          .middle_x = 341.0,
                          .middle_y = 236.0,
                          .distortion = {-0.297, 0.15, 0.00117, -0.00022, -0.095}};

/// The formula as it stands in the documents of the format, written out once more.
Pixel by_hand(const CameraModel& c, const Vec3& p) {
    const double x = p.x / p.z;
    const double y = p.y / p.z;
    const double r = std::sqrt(x * x + y * y);
    const double s =
        1.0 + c.distortion[0] * std::pow(r, 2) + c.distortion[1] * std::pow(r, 4) + c.distortion[4] * std::pow(r, 6);
    return {c.focal_x * (x * s + 2.0 * c.distortion[2] * x * y + c.distortion[3] * (r * r + 2.0 * x * x)) + c.middle_x,
            c.focal_y * (y * s + c.distortion[2] * (r * r + 2.0 * y * y) + 2.0 * c.distortion[3] * x * y) + c.middle_y};
}

double& parameter(CameraModel& c, std::size_t k) {
    double* const all[] = {&c.focal_x, &c.focal_y, &c.middle_x, &c.middle_y};
    return k < 4 ? *all[k] : c.distortion[k - 4];
}

TEST(Camera, ProjectsAsTheFormulaSaysAndUndistortsBack) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> wide(-0.5, 0.5);
    for (int i = 0; i < 500; ++i) {
        const Vec3 place{wide(random), 0.8 * wide(random), 1.0};
        const auto seen = project(kBarrel, place);
        ASSERT_TRUE(seen);
        const Pixel hand = by_hand(kBarrel, place);
        EXPECT_NEAR((*seen)[0], hand[0], 1e-9);
        EXPECT_NEAR((*seen)[1], hand[1], 1e-9);
        const auto ray = undistorted(kBarrel, *seen);
        ASSERT_TRUE(ray);
        EXPECT_LT(ray->residual, 1e-7);
        EXPECT_NEAR(ray->x, place.x, 1e-9);
        EXPECT_NEAR(ray->y, place.y, 1e-9);
    }
}

TEST(Camera, SlopesAreThoseOfDifferences) {
    const Vec3 place{0.11, -0.07, 0.4};
    const auto slopes = project_with_slopes(kBarrel, place);
    ASSERT_TRUE(slopes);
    constexpr double kStep = 1e-6;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Vec3 step{axis == 0 ? kStep : 0.0, axis == 1 ? kStep : 0.0, axis == 2 ? kStep : 0.0};
        const Pixel up = *project(kBarrel, place + step);
        const Pixel down = *project(kBarrel, place - step);
        for (std::size_t i = 0; i < 2; ++i) {
            EXPECT_NEAR(slopes->by_place[i][axis], (up[i] - down[i]) / (2.0 * kStep), 1e-4);
        }
    }
    for (std::size_t k = 0; k < CameraModel::kParameters; ++k) {
        CameraModel up = kBarrel;
        CameraModel down = kBarrel;
        parameter(up, k) += kStep;
        parameter(down, k) -= kStep;
        for (std::size_t i = 0; i < 2; ++i) {
            EXPECT_NEAR(slopes->by_camera[i][k],
                        ((*project(up, place))[i] - (*project(down, place))[i]) / (2.0 * kStep), 1e-4)
                << kCameraParameters[k];
        }
    }
    const auto ray = undistorted(kBarrel, slopes->at);
    const auto aside = undistorted(kBarrel, {slopes->at[0] + 0.001, slopes->at[1]});
    EXPECT_NEAR(ray->by_pixel[0][0], (aside->x - ray->x) / 0.001, 1e-6);
    EXPECT_NEAR(ray->by_pixel[1][0], (aside->y - ray->y) / 0.001, 1e-6);
}

TEST(Camera, RefusesWhatIsBehindOrFoldsOver) {
    EXPECT_FALSE(project(kBarrel, {0.0, 0.0, -1.0}));
    EXPECT_FALSE(project(kBarrel, {0.0, 0.0, 0.0}));
    EXPECT_FALSE(project(kBarrel, {0.0, 0.0, std::nan("")}));
    CameraModel folds = kBarrel;
    folds.distortion = {-0.5, 0.0, 0.0, 0.0, 0.0};  // grows to r = 0.816 and shrinks from there
    EXPECT_TRUE(undistorted(folds, {folds.middle_x + 0.5 * folds.focal_x, folds.middle_y}));
    EXPECT_FALSE(undistorted(folds, {folds.middle_x + 0.6 * folds.focal_x, folds.middle_y}));
}

CameraSet pair() {
    CameraSet out{
        .id = "pair", .time = {}, .parents = {}, .noise = 0.1, .cameras = {}, .right_from_left = {}, .covariance = {}};
    CameraRecord camera{.id = "left", .width = 640, .height = 480, .model = kBarrel, .fixed = {}};
    out.cameras = {camera, camera};
    out.right_from_left = CameraSet::Pose{.rotation = {}, .translation = {-0.083, 0.001, 0.002}};
    return out;
}

TEST(Triangulation, FindsThePlaceAndItsNoise) {
    const CameraSet set = pair();
    std::mt19937_64 random(4);
    std::normal_distribution<double> noise(0.0, 0.1);
    const Vec3 place{0.03, -0.02, 0.35};
    const Pixel left = *project(set.cameras[0].model, place);
    const Pixel right = *project(set.cameras[1].model, in_right(set, place));
    EXPECT_NEAR(epipolar_distance(set, left, right), 0.0, 1e-6);
    EXPECT_NEAR(std::abs(epipolar_distance(set, left, {right[0], right[1] + 1.0})), 1.0, 0.2);
    double squares = 0.0;
    double stated = 0.0;
    constexpr int kTrials = 400;
    for (int i = 0; i < kTrials; ++i) {
        const auto at = triangulate(
            set, {.at = {left[0] + noise(random), left[1] + noise(random)}, .covariance = {0.01, 0.0, 0.01}},
            {.at = {right[0] + noise(random), right[1] + noise(random)}, .covariance = {0.01, 0.0, 0.01}});
        ASSERT_TRUE(at);
        squares += std::pow(at->place.z - place.z, 2);
        stated += at->noise[2][2];
    }
    EXPECT_NEAR(std::sqrt(squares / stated), 1.0, 0.12);
    EXPECT_FALSE(triangulate(set, {.at = left}, {.at = {left[0] + 60.0, left[1]}}));  // the rays part
}

TEST(Triangulation, TellsTheCalibrationsOwnUncertainty) {
    CameraSet set = pair();
    set.covariance.assign(24, std::vector<double>(24, 0.0));
    set.covariance[21][21] = 1e-4 * 1e-4;  // the base line: 0.1 of 83 mm
    const Vec3 place{0.03, -0.02, 0.35};
    const SeenPoint left{.at = *project(set.cameras[0].model, place)};
    const SeenPoint right{.at = *project(set.cameras[1].model, in_right(set, place))};
    const auto at = triangulate(set, left, right);
    ASSERT_TRUE(at);
    EXPECT_NEAR(std::sqrt(at->calibration[2][2]), 0.35 * 0.1 / 83.0, 0.05 * 0.35 * 0.1 / 83.0);
}

}  // namespace
}  // namespace sc::host
