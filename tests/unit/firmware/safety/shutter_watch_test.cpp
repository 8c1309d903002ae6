// SPDX-License-Identifier: Apache-2.0
#include "firmware/safety/shutter_watch.hpp"

#include <gtest/gtest.h>

namespace sc::safety {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr DigitalInputs kOpen{.shutter_open = true};
constexpr DigitalInputs kShut{.shutter_closed = true};
constexpr DigitalInputs kBetween{};
constexpr DigitalInputs kBoth{.shutter_open = true, .shutter_closed = true};

/// Ticks of disagreement that are borne.
int borne(ShutterWatch& watch, bool open, const DigitalInputs& in) {
    int ticks = 0;
    while (ticks < 10'000 && !watch.wrong(open, in)) {
        ++ticks;
    }
    return ticks;
}

TEST(ShutterWatch, BearsItsWayForItsTimeAndNoLonger) {
    for (const DigitalInputs& in : {kBetween, kBoth, kShut}) {
        ShutterWatch watch(500 * kMs, kMs);
        ASSERT_FALSE(watch.wrong(false, kShut));
        EXPECT_EQ(borne(watch, true, in), 500);
        EXPECT_FALSE(watch.proven_open());
    }
}

TEST(ShutterWatch, IsProvenOpenByBothSwitchesAndTheCommand) {
    ShutterWatch watch(500 * kMs, kMs);
    EXPECT_FALSE(watch.wrong(true, kBetween));
    EXPECT_FALSE(watch.proven_open());
    EXPECT_FALSE(watch.wrong(true, kOpen));
    EXPECT_TRUE(watch.proven_open());
    EXPECT_FALSE(watch.wrong(false, kOpen)) << "on its way";
    EXPECT_FALSE(watch.proven_open());
    EXPECT_FALSE(watch.wrong(false, kShut));
    EXPECT_TRUE(watch.agrees());
    EXPECT_FALSE(watch.proven_open());
}

TEST(ShutterWatch, LeavingItsPlaceUntoldIsWrongAtOnce) {
    for (const DigitalInputs& in : {kBetween, kBoth, kShut}) {
        ShutterWatch watch(500 * kMs, kMs);
        ASSERT_FALSE(watch.wrong(true, kOpen));
        EXPECT_TRUE(watch.wrong(true, in));
        EXPECT_FALSE(watch.proven_open());
    }
    ShutterWatch watch(500 * kMs, kMs);
    ASSERT_FALSE(watch.wrong(false, kShut));
    EXPECT_TRUE(watch.wrong(false, kOpen));
}

TEST(ShutterWatch, EachCommandHasItsOwnTime) {
    ShutterWatch watch(500 * kMs, kMs);
    EXPECT_EQ(borne(watch, false, kBetween), 500);
    EXPECT_EQ(borne(watch, true, kBetween), 500);
    EXPECT_TRUE(watch.wrong(true, kBetween));
    EXPECT_FALSE(watch.wrong(true, kOpen)) << "late, but there";
}

}  // namespace
}  // namespace sc::safety
