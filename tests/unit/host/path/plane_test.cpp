// SPDX-License-Identifier: Apache-2.0
#include "host/path/plane.hpp"

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sc::host {
namespace {

TEST(FitPlane, FindsAnExactPlane) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> across(-0.3, -0.1);
    std::vector<Vec3> points;
    for (int i = 0; i < 20; ++i) {
        const double x = across(random);
        const double z = across(random);
        points.push_back({x, 0.02 * x - 0.013 * z - 0.25, z});
    }
    const FacePlane plane = fit_plane(points);
    EXPECT_NEAR(plane.slope_x, 0.02, 1e-12);
    EXPECT_NEAR(plane.slope_z, -0.013, 1e-12);
    EXPECT_LT(plane.rms, 1e-15);
    EXPECT_NEAR(plane.depth(-0.2, -0.4), 0.02 * -0.2 + 0.013 * 0.4 - 0.25, 1e-12);
}

TEST(FitPlane, NoOtherPlaneHasLessError) {
    std::mt19937 random(11);
    std::normal_distribution<double> noise(0.0, 1e-4);
    std::uniform_real_distribution<double> across(-0.1, 0.1);
    std::vector<Vec3> points;
    for (int i = 0; i < 12; ++i) {
        const double x = across(random);
        const double z = across(random);
        points.push_back({x, 0.1 * x + noise(random), z});
    }
    const FacePlane best = fit_plane(points);
    const auto squares = [&](FacePlane plane) {
        double sum = 0.0;
        for (const Vec3& p : points) {
            const double off = p.y - plane.depth(p.x, p.z);
            sum += off * off;
        }
        return sum;
    };
    for (const double step : {-1e-5, 1e-5}) {
        FacePlane other = best;
        other.slope_x += step;
        EXPECT_GT(squares(other), squares(best));
        other = best;
        other.slope_z += step;
        EXPECT_GT(squares(other), squares(best));
        other = best;
        other.centroid.y += step;
        EXPECT_GT(squares(other), squares(best));
    }
}

TEST(FitPlane, OnePointGivesThePlaneAcrossTheBeam) {
    const FacePlane plane = fit_plane(std::array{Vec3{-0.2, -0.3, -0.4}});
    EXPECT_EQ(plane.slope_x, 0.0);
    EXPECT_EQ(plane.slope_z, 0.0);
    EXPECT_EQ(plane.depth(0.0, 0.0), -0.3);
}

TEST(FitPlane, PointsOnALineSlopeAlongItAlone) {
    const FacePlane plane = fit_plane(std::array{Vec3{-0.2, -0.30, -0.4}, Vec3{-0.1, -0.29, -0.4}});
    EXPECT_NEAR(plane.slope_x, 0.1, 1e-12);
    EXPECT_NEAR(plane.slope_z, 0.0, 1e-12);
}

TEST(FitPlane, ScatterAcrossALineMakesNoSlope) {
    // 0.05 mm of scatter in z with 0.05 mm in depth would be a slope of one.
    const FacePlane plane = fit_plane(
        std::array{Vec3{-0.30, -0.3, -0.40000}, Vec3{-0.20, -0.30005, -0.40005}, Vec3{-0.10, -0.3, -0.40000}});
    EXPECT_LT(std::abs(plane.slope_z), 1e-3);
}

}  // namespace
}  // namespace sc::host
