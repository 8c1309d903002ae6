// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/element.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace sc::motion {
namespace {

AxisLimits limits() {
    AxisLimits l;
    l.speed = {0.2, 0.2, 0.2, 45.0};
    l.acceleration = {5.0, 5.0, 5.0, 180.0};
    l.jerk = {200.0, 200.0, 200.0, 1800.0};
    return l;
}

Place direction(double degrees) {
    const double a = degrees * std::acos(-1.0) / 180.0;
    return {std::cos(a), 0.0, std::sin(a), 0.0};
}

class Blend : public testing::TestWithParam<double> {};

TEST_P(Blend, LeavesAndMeetsTheLinesSmoothlyAndStaysWithinItsDeviation) {
    const double half = 40e-6;
    const Place d1 = direction(0.0);
    const Place d2 = direction(GetParam());
    const Place corner{0.1, 0.2, 0.3, 7.0};
    Place from = corner;
    Place to = corner;
    double bend = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        from[i] -= half * d1[i];
        to[i] += half * d2[i];
        bend += (d2[i] - d1[i]) * (d2[i] - d1[i]);
    }
    const Element e = make_blend(from, d1, d2, half, 1.0, limits());
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(e.place(0.0)[i], from[i], 1e-15);
        EXPECT_NEAR(e.place(e.length)[i], to[i], 1e-15);
    }
    const Place middle = e.place(half);
    double deviation = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        deviation += (middle[i] - corner[i]) * (middle[i] - corner[i]);
    }
    EXPECT_NEAR(std::sqrt(deviation), 0.1875 * half * std::sqrt(bend), 1e-14);

    // At the cap, differences of a finely sampled pass keep each axis' acceleration and jerk, and one of them is used
    // up.
    const double dt = e.length / e.cap / 2000.0;
    double worst = 0.0;
    double length = 0.0;
    for (int k = 0; k <= 1997; ++k) {
        std::array<Place, 4> p{};
        for (int n = 0; n < 4; ++n) {
            p[static_cast<std::size_t>(n)] = e.place(e.cap * dt * (k + n));
        }
        double step = 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
            step += std::pow(p[1][i] - p[0][i], 2);
            const double a = (p[2][i] - 2 * p[1][i] + p[0][i]) / (dt * dt);
            worst = std::max(worst, std::abs(a) / 5.0);
        }
        length += std::sqrt(step);
    }
    EXPECT_LE(worst, 1.001);
    EXPECT_NEAR(length / e.true_length, 1998.0 / 2000.0, 2e-3);
    EXPECT_NEAR(e.distance_at(e.length), e.true_length, 1e-15);
}

INSTANTIATE_TEST_SUITE_P(Angles, Blend, testing::Values(1.0, 10.0, 30.0, 60.0, 90.0, 115.0));

TEST(Element, LengthAlongABlendMatchesItsChordSumAsWellAsItsPolynomialCan) {
    // Worst error of the length over the blend's own, and of the stretch: at 90° 4e-4 and 0.3 %.
    const std::array<std::array<double, 3>, 4> cases{
        {{1.0, 1e-7, 1e-6}, {30.0, 1.5e-5, 4e-5}, {90.0, 4e-4, 3e-3}, {120.0, 1.6e-3, 1.2e-2}}};
    for (const auto& [angle, worst_length, worst_stretch] : cases) {
        const Element e = make_blend({0, 0, 0, 0}, direction(0), direction(angle), 1e-3, 1.0, limits());
        EXPECT_NEAR(e.length_to(0.0), 0.0, 1e-15);
        EXPECT_NEAR(e.stretch(0.0), 1.0, 1e-12);
        EXPECT_NEAR(e.stretch(e.length), 1.0, 1e-12);
        double sum = 0.0;
        Place last = e.place(0.0);
        for (int k = 1; k <= 4000; ++k) {
            const double t = e.length * k / 4000.0;
            const Place p = e.place(t);
            const double chord = std::hypot(p[0] - last[0], p[2] - last[2]);
            sum += chord;
            last = p;
            ASSERT_NEAR(e.length_to(t), sum, worst_length * e.length + 1e-9) << angle << "° " << k;
            ASSERT_NEAR(e.stretch(t - e.length / 8000.0), chord * 4000.0 / e.length, worst_stretch + 1e-6) << angle;
        }
        EXPECT_NEAR(e.length_to(e.length), sum, 5e-9);
    }
}

TEST(Element, LineTakesTheLimitOfTheAxisThatIsHardestPressed) {
    AxisLimits l = limits();
    l.acceleration[2] = 1.0;
    const Element e = make_line({0, 0, 0, 0}, direction(30.0), 0.1, 10.0, l);
    EXPECT_NEAR(e.limits.acceleration, 2.0, 1e-12);  // 1 / sin 30°
    EXPECT_NEAR(e.limits.jerk, 200.0 / std::cos(std::acos(-1.0) / 6.0), 1e-9);
    EXPECT_NEAR(e.cap, 0.2 / std::cos(std::acos(-1.0) / 6.0), 1e-12);
    EXPECT_EQ(e.limited, LimitedBy::axis_speed);
}

}  // namespace
}  // namespace sc::motion
