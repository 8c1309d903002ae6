// SPDX-License-Identifier: Apache-2.0
#include "shared/math/angle.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace sc {
namespace {

TEST(Angle, SineAndCosineOfSmallAngles) {
    for (int i = -5000; i <= 5000; ++i) {
        const double angle = 1e-4 * i;
        const SineCosine found = sine_cosine_of_small(angle);
        ASSERT_NEAR(found.sine, std::sin(angle), 2e-16);
        ASSERT_NEAR(found.cosine, std::cos(angle), 3e-16);
    }
}

TEST(Angle, OfADirectionIsThatOfTheWholeTurn) {
    for (int i = 0; i < 100'000; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / 100'000.0;
        const double length = 1e-6 + i;
        ASSERT_NEAR(angle_of(length * std::cos(angle), length * std::sin(angle)), angle, 3e-15) << i;
    }
}

TEST(Angle, AxesAndNothing) {
    EXPECT_EQ(angle_of(0.0, 0.0), 0.0);
    EXPECT_EQ(angle_of(2.0, 0.0), 0.0);
    EXPECT_NEAR(angle_of(0.0, 3.0), 0.5 * std::numbers::pi, 1e-15);
    EXPECT_NEAR(angle_of(-1e-9, 0.0), std::numbers::pi, 1e-15);
    EXPECT_NEAR(angle_of(0.0, -1.0), 1.5 * std::numbers::pi, 1e-15);
    EXPECT_NEAR(angle_of(1.0, -1e-20), 2.0 * std::numbers::pi, 1e-15);
}

}  // namespace
}  // namespace sc
