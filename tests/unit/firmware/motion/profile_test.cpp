// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/profile.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace sc::motion {
namespace {

struct Integrated {
    double distance = 0.0;
    double speed = 0.0;
    double acceleration = 0.0;
    double peak_speed = 0.0;
    double peak_acceleration = 0.0;
    double time = 0.0;
};

/// The phases summed by elementary mechanics, starting at v0.
Integrated integrate(const PhaseList& list, double v0) {
    Integrated r;
    r.speed = v0;
    r.peak_speed = v0;
    for (std::size_t i = 0; i < list.count; ++i) {
        const Phase& p = list.phase[i];
        EXPECT_NEAR(p.start_acceleration, r.acceleration, 1e-9) << "acceleration jumps at phase " << i;
        const double t = p.duration;
        r.distance += r.speed * t + r.acceleration * t * t / 2 + p.jerk * t * t * t / 6;
        r.speed += r.acceleration * t + p.jerk * t * t / 2;
        r.acceleration += p.jerk * t;
        r.peak_speed = std::max(r.peak_speed, r.speed);
        r.peak_acceleration = std::max(r.peak_acceleration, std::abs(r.acceleration));
        r.time += t;
    }
    return r;
}

TEST(Profile, ReachesExactlyAndKeepsLimitsOverRandomMoves) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::uniform_real_distribution<double> decade(-7.0, 0.0);
    for (int i = 0; i < 20'000; ++i) {
        const TangentLimits limits{std::pow(10.0, 3.0 * unit(random) - 1.0), std::pow(10.0, 5.0 * unit(random))};
        const double cap = 0.001 + unit(random);
        const double distance = std::pow(10.0, decade(random));
        const double v0 = cap * unit(random) * (i % 3 == 0 ? 0.0 : 1.0);
        const double reach = std::min(cap, reachable_speed(v0, distance, limits));
        double v1 = reach * unit(random);
        if (change_distance(v0, v1, limits) > distance) {
            v1 = std::min(cap, std::max(reach, lowest_speed(v0, distance, limits)));
        }
        const Integrated r = integrate(fastest_profile(v0, v1, cap, distance, limits), v0);
        ASSERT_NEAR(r.distance, distance, 1e-7 * distance + 1e-12);
        ASSERT_NEAR(r.speed, v1, 1e-9);
        ASSERT_NEAR(r.acceleration, 0.0, 1e-6 * limits.acceleration);
        ASSERT_LE(r.peak_speed, cap * (1.0 + 1e-12));
        ASSERT_LE(r.peak_acceleration, limits.acceleration * (1.0 + 1e-9));
    }
}

TEST(Profile, ReachableSpeedIsTheMostThatTheDistanceAllows) {
    std::mt19937_64 random(6);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::uniform_real_distribution<double> decade(-8.0, 1.0);
    for (int i = 0; i < 20'000; ++i) {
        const TangentLimits limits{0.1 + 10.0 * unit(random), 1.0 + 1000.0 * unit(random)};
        const double v0 = i % 4 == 0 ? 0.0 : unit(random);
        const double distance = std::pow(10.0, decade(random));
        const double v1 = reachable_speed(v0, distance, limits);
        ASSERT_LE(change_distance(v0, v1, limits), distance * (1.0 + 1e-12) + 1e-12);  // one picometre
        const double more = v0 + (v1 - v0) * (1.0 + 1e-6) + 2e-9 * v0 + 1e-12;
        ASSERT_GE(change_distance(v0, more, limits), distance * (1.0 - 1e-7) - 1e-12)
            << "v0 " << v0 << " distance " << distance;
    }
}

TEST(Profile, SevenPhasesFromRestToRestTakeTheKnownTime) {
    // 0.2 m at 0.2 m/s, 5 m/s², 200 m/s³: T = L/v + v/a + a/j.
    const TangentLimits limits{5.0, 200.0};
    const Integrated r = integrate(fastest_profile(0.0, 0.0, 0.2, 0.2, limits), 0.0);
    EXPECT_NEAR(r.time, 1.0 + 0.04 + 0.025, 1e-12);
    EXPECT_EQ(fastest_profile(0.0, 0.0, 0.2, 0.2, limits).count, 7U);
}

TEST(Profile, NoDistanceGivesNoPhases) {
    EXPECT_EQ(fastest_profile(0.0, 0.0, 0.2, 0.0, {5.0, 200.0}).count, 0U);
    EXPECT_EQ(reachable_speed(0.1, 0.0, {5.0, 200.0}), 0.1);
    EXPECT_EQ(lowest_speed(0.0, 0.0, {5.0, 200.0}), 0.0);
}

}  // namespace
}  // namespace sc::motion
