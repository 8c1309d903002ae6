// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/turntable_fit.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr double kDegree = 0.017453292519943295;

Mat3 turn(double angle, const Vec3& about) {
    const double s = std::sin(0.5 * angle) / norm(about);
    return rotation_of_quaternion({std::cos(0.5 * angle), s * about.x, s * about.y, s * about.z});
}

struct Table {
    Vec3 point{0.1, 0.3, 0.8};
    Vec3 axis = (1.0 / std::sqrt(0.01 + 0.64 + 0.35)) * Vec3{0.1, 0.8, std::sqrt(0.35)};
    std::vector<MarkerView> views;

    Table(unsigned seed, int angles, double arc_deg, double sigma = 7.5e-6, double table = 8.73e-6) {
        std::mt19937_64 random(seed);
        std::normal_distribution<double> normal;
        for (int i = 0; i < angles; ++i) {
            MarkerView view;
            view.line = i + 2;
            view.view = std::to_string(i + 1);
            view.turn = arc_deg * kDegree * i / angles;
            const Mat3 r = turn(*view.turn + table * normal(random), axis);
            for (int k = 0; k < 6; ++k) {
                const Vec3 arm{0.04 * (k % 3) - 0.05, 0.03 * (k / 3), 0.02 * k - 0.03};
                const double a = sigma * normal(random);
                const double b = sigma * normal(random);
                view.markers.push_back({i + 2, k + 1, point + r * arm + Vec3{a, b, sigma * normal(random)}, {}});
            }
            views.push_back(view);
        }
    }
    /// Distance of a line from the true axis beside `point`.
    [[nodiscard]] double off(const TurntableFit& fit) const {
        const Vec3 there = fit.point + (dot(point - fit.point, axis) / dot(fit.direction, axis)) * fit.direction;
        return norm(there - point);
    }
};

std::string refusal(const std::function<void()>& work) {
    try {
        work();
    } catch (const InputError& error) {
        return error.what();
    }
    return "nothing was refused";
}

TEST(TurntableFit, AFullTurnAndAnArcGiveTheAxisWithItsSign) {
    for (const double arc : {360.0, 90.0}) {
        const Table table(1, 12, arc);
        const TurntableFit fit = fit_turntable("axis.csv", table.views);
        EXPECT_LT(norm(fit.direction - table.axis), arc > 180.0 ? 1e-4 : 4e-4);
        EXPECT_LT(table.off(fit), arc > 180.0 ? 10e-6 : 40e-6);
        EXPECT_NEAR(fit.arc / kDegree, arc * 11 / 12, 1e-6);
        EXPECT_NEAR(fit.chi_squared / fit.freedom, 1.0, 0.35);
        EXPECT_TRUE(fit.markers.empty());
    }
}

TEST(TurntableFit, CovarianceOfThePlaceHolds) {
    double inside = 0.0;
    constexpr int kSets = 100;
    for (unsigned seed = 1; seed <= kSets; ++seed) {
        const Table table(seed, 8, 120.0);
        const TurntableFit fit = fit_turntable("axis.csv", table.views);
        const Vec3 there =
            table.point + (dot(fit.point - table.point, fit.direction) / dot(table.axis, fit.direction)) * table.axis;
        const double off = dot(there - fit.point, fit.across[0]);
        inside += std::abs(off) < 1.96 * std::sqrt(fit.covariance.at[0][0]) ? 1.0 : 0.0;
    }
    EXPECT_GT(inside / kSets, 0.88);
    EXPECT_LT(inside / kSets, 1.0);
}

TEST(TurntableFit, AWrongAngleAndAWrongMarkerAreNamed) {
    Table table(2, 12, 360.0);
    table.views[4].turn = *table.views[4].turn + 0.2 * kDegree;
    table.views[9].markers[1].place = table.views[9].markers[1].place + Vec3{2e-3, 0.0, 0.0};
    const TurntableFit fit = fit_turntable("axis.csv", table.views);
    EXPECT_EQ(std::ranges::count(fit.views, false, &TurntableView::used), 1);
    EXPECT_FALSE(fit.views[4].used);
    ASSERT_EQ(fit.markers.size(), 1U);
    EXPECT_EQ(fit.markers[0].view, "10");
    EXPECT_EQ(fit.markers[0].id, 2);
    EXPECT_LT(table.off(fit), 15e-6);
}

TEST(TurntableFit, NoiseIsFoundFromTheData) {
    const Table table(3, 24, 360.0, 60e-6, 6e-5);
    TurntableOptions options;
    options.fit_noise = true;
    EXPECT_NEAR(fit_turntable("axis.csv", table.views, options).noise_ratio, 8.0, 1.5);
}

TEST(TurntableFit, WhatShowsNoAxisIsRefused) {
    Table still(4, 6, 0.5);
    EXPECT_NE(refusal([&] { (void)fit_turntable("axis.csv", still.views); }).find("hardly turned"), std::string::npos);
    Table two(5, 2, 360.0);
    EXPECT_NE(refusal([&] { (void)fit_turntable("axis.csv", two.views); }).find("2 angles"), std::string::npos);
    Table blank(6, 6, 360.0);
    blank.views[3].turn.reset();
    const std::string text = refusal([&] { (void)fit_turntable("axis.csv", blank.views); });
    EXPECT_NE(text.find("axis.csv:5"), std::string::npos) << text;
    EXPECT_NE(text.find("no angle"), std::string::npos) << text;
}

TEST(TurntableFit, PosesOfATargetDoAsWell) {
    const Table table(7, 12, 360.0);
    std::vector<NamedPose> poses;
    for (int i = 0; i < 12; ++i) {
        const double angle = 30.0 * kDegree * i;
        NamedPose pose;
        pose.line = i + 2;
        pose.view = std::to_string(i);
        pose.turn = angle;
        pose.rotation = turn(angle, table.axis) * turn(0.4, {1.0, 0.0, 0.3});
        pose.translation = table.point + turn(angle, table.axis) * Vec3{0.1, 0.05, 0.0};
        poses.push_back(pose);
    }
    const TurntableFit fit = fit_turntable_poses("poses.csv", poses, 1e-5);
    EXPECT_LT(norm(fit.direction - table.axis), 1e-9);
    EXPECT_LT(table.off(fit), 1e-9);
}

}  // namespace
}  // namespace sc::host
