// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "firmware/trajectory/line.hpp"
#include "firmware/trajectory/piece.hpp"
#include "firmware/trajectory/polygon.hpp"

namespace sc::trajectory {
namespace {

TEST(Hermite, MeetsBothEnds) {
    const Quintic k = hermite({1.0, -2.0, 3.0}, {4.0, 0.5, -1.0}, 0.7);
    EXPECT_NEAR(value(k, 0.7), 4.0, 1e-12);
    EXPECT_NEAR(rate(k, 0.7), 0.5, 1e-11);
    EXPECT_NEAR(second_rate(k, 0.7), -1.0, 1e-10);
    EXPECT_EQ(rate(k, 0.0), -2.0);
    EXPECT_EQ(second_rate(k, 0.0), 3.0);
}

TEST(Peaks, AreThoseOfADenseSearch) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    for (int n = 0; n < 500; ++n) {
        Quintic k{};
        for (double& c : k) {
            c = any(random);
        }
        const double duration = 0.2 + std::abs(any(random));
        const Peaks found = peaks(k, duration);
        double acceleration = 0.0;
        double jerk = 0.0;
        for (int i = 0; i <= 4000; ++i) {
            const double t = duration * i / 4000.0;
            acceleration = std::max(acceleration, std::abs(second_rate(k, t)));
            jerk = std::max(jerk, std::abs(third_rate(k, t)));
        }
        EXPECT_GE(found.acceleration, acceleration - 1e-12);
        EXPECT_NEAR(found.acceleration, acceleration, 1e-5 * (1.0 + acceleration));
        EXPECT_GE(found.jerk, jerk - 1e-12);
        EXPECT_NEAR(found.jerk, jerk, 1e-5 * (1.0 + jerk));
    }
}

TEST(Polygon, ClipKeepsWhatTheHalfPlaneHolds) {
    Polygon square;
    square.box(2.0, 1.0);
    square.clip(1.0, 1.0, 2.0);  // cuts the corner (2, 1)
    EXPECT_EQ(square.count, 5U);
    for (std::uint32_t i = 0; i < square.count; ++i) {
        EXPECT_LE(square.b[i] + square.c[i], 2.0 + 1e-15);
    }
    square.clip(-1.0, 0.0, -5.0);
    EXPECT_EQ(square.count, 0U);
}

TEST(Polygon, SimplifyStaysWithin) {
    Polygon round;
    round.count = 24;
    for (std::uint32_t i = 0; i < round.count; ++i) {
        round.b[i] = std::cos(0.2617993877991494 * i);
        round.c[i] = std::sin(0.2617993877991494 * i);
    }
    round.simplify(9);
    EXPECT_EQ(round.count, 9U);
    for (std::uint32_t i = 0; i < round.count; ++i) {
        EXPECT_NEAR(std::hypot(round.b[i], round.c[i]), 1.0, 1e-15);
    }
}

/// State at the end of a phase.
Phase after(const Phase& p) {
    const double t = p.duration;
    return {0.0, p.s + t * (p.v + t * (p.a / 2 + t * p.j / 6)), p.v + t * (p.a + t * p.j / 2), p.a + t * p.j, 0.0};
}

TEST(LinePlan, IsContinuousAndWithinLimitsForAnyRamps) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> any(0.0, 1.0);
    for (int n = 0; n < 5000; ++n) {
        const double length = std::pow(10.0, -8.0 + 8.0 * any(random));
        const Along limits{std::pow(10.0, -3.0 + 3.0 * any(random)), std::pow(10.0, -1.0 + 3.0 * any(random)),
                           std::pow(10.0, 4.0 * any(random))};
        const double longest = std::min({std::cbrt(length / (2 * limits.jerk)), limits.acceleration / limits.jerk,
                                         std::sqrt(limits.speed / limits.jerk)});
        const Joint head{longest * any(random), limits.jerk * (0.3 + 0.7 * any(random))};
        const Joint tail{longest * any(random), limits.jerk * (0.3 + 0.7 * any(random))};
        const LinePlan plan = plan_line(length, limits, head, tail);
        ASSERT_GT(plan.count, 0U);
        Phase at{};
        for (std::uint32_t i = 0; i < plan.count; ++i) {
            const Phase& p = plan.phase[i];
            ASSERT_GT(p.duration, 0.0);
            ASSERT_NEAR(p.s, at.s, 1e-12 * length + 1e-18);
            ASSERT_NEAR(p.v, at.v, 1e-9 * limits.speed);
            ASSERT_NEAR(p.a, at.a, 1e-7 * limits.acceleration);
            ASSERT_LE(std::abs(p.j), limits.jerk * (1 + 1e-12));
            at = after(p);
            ASSERT_LE(at.v, limits.speed * (1 + 1e-9));
            ASSERT_LE(std::abs(at.a), limits.acceleration * (1 + 1e-9));
        }
        ASSERT_NEAR(at.s, length, 1e-12 * length + 1e-18);
        ASSERT_NEAR(at.v, 0.0, 1e-9 * limits.speed);
    }
}

}  // namespace
}  // namespace sc::trajectory
