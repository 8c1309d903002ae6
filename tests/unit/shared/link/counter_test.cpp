// SPDX-License-Identifier: Apache-2.0
#include "shared/link/counter.hpp"

#include <gtest/gtest.h>

namespace {

using sc::link::CounterWatch;

TEST(CounterWatch, TakesACountThatWraps) {
    CounterWatch watch;
    watch.restart(0xFFFD);
    for (const unsigned counter : {0xFFFEU, 0xFFFFU, 0U, 1U}) {
        EXPECT_TRUE(watch.take(static_cast<std::uint16_t>(counter)));
    }
    EXPECT_EQ(watch.lost(), 0U);
}

TEST(CounterWatch, CountsTheMissing) {
    CounterWatch watch;
    watch.restart(10);
    EXPECT_TRUE(watch.take(14));
    EXPECT_EQ(watch.lost(), 3U);
}

TEST(CounterWatch, RefusesRepeatedAndLate) {
    CounterWatch watch;
    watch.restart(100);
    EXPECT_FALSE(watch.take(100));
    EXPECT_FALSE(watch.take(99));
    EXPECT_FALSE(watch.take(37));
    EXPECT_EQ(watch.repeated(), 3U);
    EXPECT_TRUE(watch.take(101));
    EXPECT_EQ(watch.lost(), 0U);
}

TEST(CounterWatch, FindsTheWayBackAfterALongSilence) {
    CounterWatch watch;
    watch.restart(0);
    EXPECT_TRUE(watch.take(40'000)) << "ahead by more than half the range";
    EXPECT_TRUE(watch.take(40'001));
    EXPECT_EQ(watch.lost(), 39'999U);
}

}  // namespace
