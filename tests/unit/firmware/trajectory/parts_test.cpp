// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>
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

Polygon box(double b, double c) {
    Polygon made;
    made.box(b, c);
    return made;
}

Polygon circle(std::uint32_t count) {
    Polygon round;
    round.count = count;
    for (std::uint32_t i = 0; i < count; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / count;
        round.put(i, {std::cos(angle), std::sin(angle)});
    }
    return round;
}

double area(const Polygon& polygon) {
    double sum = 0.0;
    for (std::uint32_t i = 0; i < polygon.count; ++i) {
        const State a = polygon.at(i);
        const State z = polygon.at((i + 1) % polygon.count);
        sum += a.b * z.c - a.c * z.b;
    }
    return 0.5 * sum;
}

TEST(Polygon, ClipKeepsWhatTheHalfPlaneHolds) {
    Polygon square = box(2.0, 1.0);
    square.clip(1.0, 1.0, 2.0);  // cuts the corner (2, 1)
    EXPECT_EQ(square.count, 5U);
    for (std::uint32_t i = 0; i < square.count; ++i) {
        EXPECT_LE(square.b[i] + square.c[i], 2.0 + 1e-15);
    }
    square.clip(-1.0, 0.0, -5.0);
    EXPECT_EQ(square.count, 0U);
}

TEST(Polygon, ClipCutsTheSameAreaWhereverTheArrayBegins) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    for (int n = 0; n < 2000; ++n) {
        Polygon one = circle(3 + static_cast<std::uint32_t>(n) % 20);
        Polygon other;
        other.count = one.count;
        const std::uint32_t turn = static_cast<std::uint32_t>(random() % one.count);
        for (std::uint32_t i = 0; i < one.count; ++i) {
            other.put(i, one.at((i + turn) % one.count));
        }
        Polygon rest = one;
        const double whole = area(one);
        const double nb = any(random);
        const double nc = any(random);
        const double d = any(random);
        one.clip(nb, nc, d);
        other.clip(nb, nc, d);
        rest.clip(-nb, -nc, -d);
        ASSERT_NEAR(area(one), area(other), 1e-14);
        ASSERT_NEAR(area(one) + area(rest), whole, 1e-14);
        ASSERT_GE(area(one), -1e-15);
        for (std::uint32_t i = 0; i < one.count; ++i) {
            ASSERT_LE(nb * one.b[i] + nc * one.c[i], d + 1e-14);
        }
        Polygon slab = circle(one.count + 3);
        slab.clip_both(nb, nc, std::abs(d));
        for (std::uint32_t i = 0; i < slab.count; ++i) {
            ASSERT_LE(std::abs(nb * slab.b[i] + nc * slab.c[i]), std::abs(d) + 1e-14);
        }
    }
}

TEST(Polygon, SimplifyStaysWithin) {
    Polygon round = circle(24);
    round.simplify(9);
    EXPECT_EQ(round.count, 9U);
    for (std::uint32_t i = 0; i < round.count; ++i) {
        EXPECT_NEAR(std::hypot(round.b[i], round.c[i]), 1.0, 1e-15);
    }
}

TEST(Polygon, SimplifyKeepsAStateInside) {
    const State kept{0.0, 0.99};
    Polygon round = circle(40);
    round.simplify(6, &kept);
    EXPECT_EQ(round.count, 6U);
    for (std::uint32_t i = 0; i < round.count; ++i) {
        const State a = round.at(i);
        const State z = round.at((i + 1) % round.count);
        EXPECT_GT((z.b - a.b) * (kept.c - a.c) - (z.c - a.c) * (kept.b - a.b), 0.0);
    }
}

TEST(Polygon, SimplifyDropsWhatIsButRounding) {
    Polygon square = box(2.0, 1.0);
    square.move(4, 3);
    square.put(3, {1e-15, 1.0});
    square.count = 5;
    square.simplify(10);
    EXPECT_EQ(square.count, 4U);
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
