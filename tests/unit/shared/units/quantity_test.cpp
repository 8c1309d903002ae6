// SPDX-License-Identifier: Apache-2.0
#include "shared/units/quantity.hpp"

#include <type_traits>

#include <gtest/gtest.h>

namespace sc {
namespace {

using namespace literals;

static_assert(!std::is_convertible_v<double, Length>, "a bare number is no length");
static_assert(!std::is_convertible_v<Speed, Length>, "a speed is no length");

TEST(Quantity, KeepsDimensionsThroughProductsAndQuotients) {
    static_assert(std::is_same_v<decltype(200_mm_s * 2.0_s), Length>);
    static_assert(std::is_same_v<decltype(200_mm_s / 2.0_s), Acceleration>);
    static_assert(std::is_same_v<decltype(4_mm / 2_mm), double>);
    EXPECT_DOUBLE_EQ((200_mm_s * 2.0_s) / 1_mm, 400.0);
    EXPECT_DOUBLE_EQ(10_um / 1_mm, 0.01);
    EXPECT_DOUBLE_EQ((80.0_W / 80_kHz) / 1.0_uJ, 1000.0);
}

TEST(Quantity, ComparesAndAdds) {
    EXPECT_LT(999_um, 1_mm);
    EXPECT_DOUBLE_EQ((1_mm + 250_um - 0.5_mm) / 1_um, 750.0);
    EXPECT_DOUBLE_EQ((-(90_deg)).si(), -kPi / 2.0);
}

}  // namespace
}  // namespace sc
