// SPDX-License-Identifier: Apache-2.0
#include "shared/hash/fnv.hpp"

#include <array>
#include <cstdint>

#include <gtest/gtest.h>

namespace {

TEST(Fnv1a64, GivesThePublishedValues) {
    EXPECT_EQ(sc::fnv1a64(""), 0xCBF29CE484222325ULL);
    EXPECT_EQ(sc::fnv1a64("a"), 0xAF63DC4C8601EC8CULL);
    EXPECT_EQ(sc::fnv1a64("foobar"), 0x85944171F73967E8ULL);
}

TEST(Fnv1a64, IsAConstantExpression) {
    static_assert(sc::fnv1a64("a") == 0xAF63DC4C8601EC8CULL);
    constexpr std::array<std::uint8_t, 1> kBytes{'a'};
    static_assert(sc::fnv1a64(kBytes) == sc::fnv1a64("a"));
}

TEST(Fnv1a64, IsTheSameInSteps) {
    EXPECT_EQ(sc::Fnv1a64{}.update("foo").update("").update("bar").value(), sc::fnv1a64("foobar"));
}

TEST(Fnv1a64, TakesBytesAbove127AsUnsigned) {
    constexpr std::array<std::uint8_t, 1> kByte{0xFF};
    EXPECT_EQ(sc::fnv1a64(kByte), (0xCBF29CE484222325ULL ^ 0xFFU) * 0x100000001B3ULL);
    EXPECT_EQ(sc::fnv1a64("\xFF"), sc::fnv1a64(kByte));
}

}  // namespace
