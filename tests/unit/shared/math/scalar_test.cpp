// SPDX-License-Identifier: Apache-2.0
#include "shared/math/scalar.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace sc {
namespace {

TEST(Scalar, CubeRootMatchesTheLibraryOverAllMagnitudes) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> exponent(-280.0, 280.0);
    for (int i = 0; i < 20'000; ++i) {
        const double v = std::pow(10.0, exponent(random));
        EXPECT_NEAR(cube_root(v) / std::cbrt(v), 1.0, 1e-15) << v;
    }
    EXPECT_EQ(cube_root(0.0), 0.0);
    EXPECT_EQ(cube_root(-8.0), 0.0);
    EXPECT_EQ(cube_root(std::numeric_limits<double>::quiet_NaN()), 0.0);
}

TEST(Nearest, RoundsHalvesToEvenAndClamps) {
    EXPECT_EQ(nearest(0.5), 0);
    EXPECT_EQ(nearest(1.5), 2);
    EXPECT_EQ(nearest(-0.5), 0);
    EXPECT_EQ(nearest(-2.5), -2);
    EXPECT_EQ(nearest(-2.5001), -3);
    EXPECT_EQ(nearest(123456789012345.4), 123456789012345);
    EXPECT_EQ(nearest(-123456789012345.6), -123456789012346);
    EXPECT_EQ(nearest(1e300), 2'251'799'813'685'248);
    EXPECT_EQ(nearest(-1e300), -2'251'799'813'685'248);
    EXPECT_EQ(nearest(std::numeric_limits<double>::quiet_NaN()), -2'251'799'813'685'248);
}

TEST(Nearest32, RoundsHalvesToEvenAndClamps) {
    EXPECT_EQ(nearest32(2.5), 2);
    EXPECT_EQ(nearest32(-3.5), -4);
    EXPECT_EQ(nearest32(2147483646.6), 2147483647);
    EXPECT_EQ(nearest32(1e10), 2147483647);
    EXPECT_EQ(nearest32(-1e10), -2147483647);
    EXPECT_EQ(nearest32(std::numeric_limits<double>::quiet_NaN()), -2147483647);
}

TEST(Scalar, RoundsHalvesAwayFromZeroAndNeverOverflows) {
    EXPECT_EQ(rounded(0.5), 1);
    EXPECT_EQ(rounded(-0.5), -1);
    EXPECT_EQ(rounded(2.4999), 2);
    EXPECT_EQ(rounded(-2.5001), -3);
    EXPECT_EQ(rounded(1e300), 9'000'000'000'000'000'000);
    EXPECT_EQ(rounded(-1e300), -9'000'000'000'000'000'000);
    EXPECT_EQ(rounded(std::numeric_limits<double>::quiet_NaN()), -9'000'000'000'000'000'000);
}

TEST(Scalar, ClampsANumberThatIsNoneToTheLowerEnd) {
    EXPECT_EQ(clamped(std::numeric_limits<double>::quiet_NaN(), -1.0, 1.0), -1.0);
    EXPECT_EQ(clamped(5.0, -1.0, 1.0), 1.0);
    EXPECT_EQ(clamped(0.25, -1.0, 1.0), 0.25);
}

TEST(NearestDouble, IsTheStaticCastOfAnyNumber) {
    for (const std::int64_t v : {INT64_MIN, INT64_MAX, INT64_MIN + 1, std::int64_t{0}, std::int64_t{-1},
                                 (std::int64_t{1} << 53) + 1, -(std::int64_t{1} << 53) - 3, std::int64_t{0xFFFF'FFFF},
                                 std::int64_t{-0x1'0000'0000}, std::int64_t{0x7FFF'FFFF'FFFF'FDFF}}) {
        EXPECT_EQ(nearest_double(v), static_cast<double>(v)) << v;
    }
    std::mt19937_64 random(2);
    for (int i = 0; i < 100'000; ++i) {
        const auto v = static_cast<std::int64_t>(random()) >> (i % 64);
        ASSERT_EQ(nearest_double(v), static_cast<double>(v)) << v;
    }
}

}  // namespace
}  // namespace sc
