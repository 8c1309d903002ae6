// SPDX-License-Identifier: Apache-2.0
#include "firmware/safety/laser_rule.hpp"

#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace sc::safety {
namespace {

using namespace literals;

MarkContext good() {
    return {.state = State::marking,
            .mark_segment = true,
            .mo_ready = true,
            .interlocks_closed = true,
            .laser_healthy = true,
            .galvo_healthy = true,
            .shutter_open = true,
            .key_production = true,
            .faults = 0,
            .path_speed = 50_mm_s,
            .path_speed_min = 2_mm_s};
}

TEST(LaserRule, PermitsWhenEverythingHolds) { EXPECT_TRUE(gate_permitted(good())); }

TEST(LaserRule, DefaultForbids) { EXPECT_FALSE(gate_permitted(MarkContext{})); }

TEST(LaserRule, EachConditionAloneForbids) {
    const std::vector<std::function<void(MarkContext&)>> spoils{
        [](MarkContext& c) { c.mark_segment = false; },
        [](MarkContext& c) { c.mo_ready = false; },
        [](MarkContext& c) { c.interlocks_closed = false; },
        [](MarkContext& c) { c.laser_healthy = false; },
        [](MarkContext& c) { c.galvo_healthy = false; },
        [](MarkContext& c) { c.shutter_open = false; },
        [](MarkContext& c) { c.key_production = false; },
        [](MarkContext& c) { c.faults = 1U << 5U; },
        [](MarkContext& c) { c.path_speed = 1.999_mm_s; },
        [](MarkContext& c) { c.path_speed = -50.0_mm_s; },
        [](MarkContext& c) { c.path_speed = Speed::from_si(std::numeric_limits<double>::quiet_NaN()); },
    };
    for (std::size_t i = 0; i < spoils.size(); ++i) {
        MarkContext context = good();
        spoils[i](context);
        EXPECT_FALSE(gate_permitted(context)) << i;
    }
}

TEST(LaserRule, OnlyOneStatePermits) {
    for (std::uint8_t i = 0; i < kStateCount; ++i) {
        MarkContext context = good();
        context.state = static_cast<State>(i);
        EXPECT_EQ(gate_permitted(context), context.state == State::marking) << name_of(context.state);
    }
}

TEST(LaserRule, MinimumSpeedItselfPermits) {
    MarkContext context = good();
    context.path_speed = context.path_speed_min;
    EXPECT_TRUE(gate_permitted(context));
}

TEST(MoSequencer, WaitsItsTimeBeforeItIsReady) {
    MoSequencer mo(8'000'000, 1'000'000);
    mo.step(State::idle);
    EXPECT_FALSE(mo.on());
    for (int tick = 0; tick < 8; ++tick) {
        mo.step(State::arming);
        EXPECT_TRUE(mo.on());
        EXPECT_FALSE(mo.ready()) << tick;
    }
    mo.step(State::arming);
    EXPECT_TRUE(mo.ready()) << "on for eight whole ticks";
    mo.step(State::marking);
    EXPECT_TRUE(mo.ready());
}

TEST(MoSequencer, ABreakStartsTheWaitAnew) {
    MoSequencer mo(3'000'000, 1'000'000);
    for (int tick = 0; tick < 5; ++tick) {
        mo.step(State::arming);
    }
    ASSERT_TRUE(mo.ready());
    mo.step(State::fault);
    EXPECT_FALSE(mo.on());
    EXPECT_FALSE(mo.ready());
    mo.step(State::arming);
    EXPECT_TRUE(mo.on());
    EXPECT_FALSE(mo.ready());
}

TEST(MoSequencer, StaysOffUntilItIsPermitted) {
    MoSequencer mo(2'000'000, 1'000'000);
    for (int tick = 0; tick < 50; ++tick) {
        mo.step(State::arming, false);
        ASSERT_FALSE(mo.on());
        ASSERT_FALSE(mo.ready());
    }
    mo.step(State::arming, true);
    EXPECT_TRUE(mo.on());
    EXPECT_FALSE(mo.ready()) << "the wait begins with the light, not with the state";
}

TEST(MoSequencer, NoWaitMeansReadyAtOnce) {
    MoSequencer mo(0, 1'000'000);
    EXPECT_FALSE(mo.ready());
    mo.step(State::arming);
    EXPECT_TRUE(mo.ready());
}

}  // namespace
}  // namespace sc::safety
