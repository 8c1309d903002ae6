// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/shutter.hpp"

#include <gtest/gtest.h>

namespace sc::sim {
namespace {

constexpr std::int64_t kMs = 1'000'000;

TEST(ShutterPlant, TakesItsTimeEitherWay) {
    ShutterPlant shutter;
    EXPECT_TRUE(shutter.reads_closed());
    shutter.command(true);
    shutter.step_to(30 * kMs);
    EXPECT_FALSE(shutter.reads_open() || shutter.reads_closed() || shutter.passes());
    shutter.step_to(60 * kMs);
    EXPECT_TRUE(shutter.reads_open() && shutter.passes());
    shutter.command(false);
    shutter.step_to(62 * kMs);
    EXPECT_FALSE(shutter.reads_open()) << "its switch lets go before the beam is cut";
    EXPECT_TRUE(shutter.passes());
    shutter.step_to(120 * kMs);
    EXPECT_TRUE(shutter.reads_closed());
}

TEST(ShutterPlant, ShutsByItselfWithoutItsLineOrItsCoil) {
    for (const bool line : {true, false}) {
        ShutterPlant shutter;
        shutter.command(true);
        shutter.step_to(60 * kMs);
        line ? shutter.allow(false) : shutter.drop(true);
        shutter.step_to(120 * kMs);
        EXPECT_TRUE(shutter.reads_closed()) << line;
    }
}

TEST(ShutterPlant, StuckItStaysAndUnpluggedItSaysNothing) {
    ShutterPlant shutter;
    shutter.command(true);
    shutter.step_to(60 * kMs);
    shutter.stick(true);
    shutter.command(false);
    shutter.step_to(200 * kMs);
    EXPECT_TRUE(shutter.reads_open());
    shutter.unplug(true);
    EXPECT_FALSE(shutter.reads_open() || shutter.reads_closed());
    EXPECT_TRUE(shutter.passes());
}

}  // namespace
}  // namespace sc::sim
