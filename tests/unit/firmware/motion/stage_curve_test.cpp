// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/stage_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace {

using sc::motion::kStageSmoothing;
using sc::motion::StageCurve;
using sc::motion::StageFollower;
using sc::motion::StageHistory;

constexpr double kTick = 1e-3;
constexpr double kT = kStageSmoothing * kTick;

std::int32_t wire(double metres) { return static_cast<std::int32_t>(std::lround(metres * 1e8)); }

/// A curve of knots 50 mm apart through a wave, by its control points.
StageCurve waved(double amplitude) {
    StageCurve curve;
    curve.open();
    EXPECT_TRUE(curve.begin(0.05));
    for (int i = 0; i < 60; ++i) {
        curve.push({wire(-0.2 + 0.003 * i), wire(-0.3), wire(amplitude * std::sin(0.4 * i))});
    }
    return curve;
}

TEST(StageCurve, IsTheSplineOfItsControlPoints) {
    const StageCurve curve = waved(0.01);
    const auto control = [](int i) { return 0.01 * std::sin(0.4 * i); };
    for (const double s : {0.0, 0.013, 0.05, 0.777, 2.0}) {
        const int i = static_cast<int>(s / 0.05);
        const double x = s / 0.05 - i;
        const double y = 1.0 - x;
        const double due = (y * y * y * control(i) + (3 * x * x * x - 6 * x * x + 4) * control(i + 1) +
                            (3 * y * y * y - 6 * y * y + 4) * control(i + 2) + x * x * x * control(i + 3)) /
                           6.0;
        EXPECT_NEAR(curve.at(s)[2], due, 1e-8) << s;
        EXPECT_NEAR(curve.at(s)[0], -0.2 + 0.003 * (s / 0.05 + 1.0), 1e-8) << "straight in, straight out";
        EXPECT_EQ(curve.at(s)[1], wire(-0.3) / 1e8) << "what stands is exactly there";
    }
    EXPECT_TRUE(curve.reaches(56.9 * 0.05));
    EXPECT_FALSE(curve.reaches(57.0 * 0.05));
}

/// Any way along the path: runs, holds of any length, and starts, as abrupt as the mirrors.
std::vector<std::int64_t> random_progress(unsigned seed, double speed) {
    std::mt19937 random(seed);
    std::vector<std::int64_t> progress;
    double distance = 0.0;
    while (progress.size() < 4000) {
        const bool stands = random() % 3 == 0;
        const double v = stands ? 0.0 : speed * (random() % 4 == 0 ? 0.3 : 1.0);
        const auto ticks = static_cast<unsigned>(1 + random() % 200);
        for (unsigned i = 0; i < ticks; ++i) {
            distance += v * kTick;
            progress.push_back(static_cast<std::int64_t>(std::llround(distance * 1e12)));
        }
    }
    return progress;
}

TEST(StageFollower, KeepsItsBoundsForAnyProgressAndComesToIt) {
    constexpr double kSpeed = 1.5;
    for (unsigned seed = 1; seed <= 20; ++seed) {
        StageFollower follower;
        follower.open();
        std::vector<double> s(4, 0.0);
        std::array<double, 3> most{};
        std::int64_t last = 0;
        for (const std::int64_t d : random_progress(seed, kSpeed)) {
            s.push_back(follower.push(d));
            last = d;
            const std::size_t n = s.size() - 1;
            const double behind = static_cast<double>(d) * 1e-12 - s[n];
            ASSERT_GE(behind, -1e-12);
            ASSERT_LE(behind, kSpeed * kT);
            ASSERT_GE(s[n], s[n - 1]);
            most[0] = std::max(most[0], (s[n] - s[n - 1]) / kTick);
            most[1] = std::max(most[1], std::abs(s[n] - 2 * s[n - 1] + s[n - 2]) / (kTick * kTick));
            most[2] =
                std::max(most[2], std::abs(s[n] - 3 * s[n - 1] + 3 * s[n - 2] - s[n - 3]) / (kTick * kTick * kTick));
        }
        EXPECT_LE(most[0], kSpeed * 1.0001);
        EXPECT_LE(most[1], kSpeed / kT * 1.0001);
        EXPECT_LE(most[2], 2.0 * kSpeed / (kT * kT) * 1.01);
        EXPECT_GT(most[1], 0.5 * kSpeed / kT) << "and the bounds are no wider than needed";
        last += 1'000'000'000;
        static_cast<void>(follower.push(last));
        for (std::uint32_t i = 0; i <= 2 * kStageSmoothing; ++i) {
            EXPECT_FALSE(follower.settled()) << i;
            static_cast<void>(follower.push(last - 1'000'000));
        }
        EXPECT_TRUE(follower.settled());
        EXPECT_DOUBLE_EQ(follower.push(last), static_cast<double>(last) * 1e-12) << "going back counts as standing";
    }
}

TEST(StageCurve, WhatTheCheckPassesKeepsTheLimitsWhateverTheProgress) {
    sc::trajectory::AxisLimits limits;
    limits.speed.fill(0.2);
    limits.acceleration.fill(5.0);
    limits.jerk.fill(200.0);
    constexpr double kSpeed = 1.0;
    std::mt19937 random(5);
    int passed = 0;
    double hardest = 0.0;
    for (int round = 0; round < 400; ++round) {
        StageCurve curve;
        curve.open();
        ASSERT_TRUE(curve.begin(0.05));
        bool good = true;
        const double size = 0.0002 * (1.0 + 0.1 * round);
        double place = 0.0;
        double step = 0.0;
        for (int i = 0; i < 100; ++i) {
            step += size * (static_cast<double>(random() % 2001) / 1000.0 - 1.0);
            step = std::clamp(step, -0.00499, 0.00499);
            place += step;
            curve.push({wire(place), 0, 0});
            good = good && !curve.check(kSpeed, kTick, limits).broken;
        }
        if (!good) {
            continue;
        }
        ++passed;
        StageFollower follower;
        follower.open();
        std::vector<double> x(4, curve.at(0.0)[0]);
        for (const std::int64_t d : random_progress(static_cast<unsigned>(round), kSpeed)) {
            if (static_cast<double>(d) * 1e-12 > 4.8) {
                break;
            }
            x.push_back(curve.at(follower.push(d))[0]);
            const std::size_t n = x.size() - 1;
            ASSERT_LE(std::abs(x[n] - x[n - 1]) / kTick, 0.1 * 1.0001);
            ASSERT_LE(std::abs(x[n] - 2 * x[n - 1] + x[n - 2]) / (kTick * kTick), 5.0 * 1.0001);
            const double jerk = std::abs(x[n] - 3 * x[n - 1] + 3 * x[n - 2] - x[n - 3]) / (kTick * kTick * kTick);
            ASSERT_LE(jerk, 200.0 * 1.001);
            hardest = std::max(hardest, jerk);
        }
    }
    EXPECT_GT(passed, 5);
    EXPECT_LT(passed, 400) << "some must be too hard";
    EXPECT_GT(hardest, 60.0);
}

TEST(StageHistory, GoesThroughTheSetPointsAtAnyLateness) {
    // A cubic is met exactly; what is smooth, nearly.
    const auto law = [](double t) { return 0.1 + 0.05 * t + 40e-6 * t * t - 30e-9 * t * t * t; };
    for (const double late : {3.0, 3.959, 4.5, 6.2, 12.0}) {
        StageHistory history;
        history.fill({law(0.0), 0.0, 0.0});
        for (int n = 0; n <= 40; ++n) {
            history.push({law(n), 0.0, 0.0});
        }
        const double node = StageHistory::next_begins(late);
        for (double x = 0.0; x <= 1.0; x += 0.01) {
            const StageHistory::Cubic k = history.law(0, late, x > node && node < 1.0);
            EXPECT_NEAR(k[0] + x * (k[1] + x * (k[2] + x * k[3])), law(40.0 - late + x), 1e-13) << late << " " << x;
        }
        EXPECT_FALSE(history.stands());
    }
    StageHistory history;
    history.fill({1.0, 2.0, 3.0});
    EXPECT_TRUE(history.stands());
}

}  // namespace
