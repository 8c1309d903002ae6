// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/io/control_clock.hpp"

#include <gtest/gtest.h>

#include "tests/stm32h743/model/slow_lines.hpp"

namespace sc::stm32h743 {
namespace {

class ControlClockTest : public testing::Test {
protected:
    ControlClockTest() { machine.attach(model::ClockGates::kBase, 0x400, clocks); }
    void TearDown() override { EXPECT_EQ(machine.violations_text(), ""); }
    model::Machine machine;
    model::ClockGates clocks{machine};
    model::Counter counter{machine, clocks};
    ControlClock clock;
};

/// The counter wraps every 17.9 s.
TEST_F(ControlClockTest, TellsControlTimeForHours) {
    ASSERT_TRUE(clock.start(-1'000'000));
    const std::int64_t zero = counter.started_ns() + 1'000'000;
    for (std::int64_t tick = 0; tick < 20'000'000; tick += 2'999) {
        machine.advance_to(zero + tick * 1'000'000 + 654'321);
        const std::int64_t now = clock.now_ns(tick);
        EXPECT_GE(now, tick * 1'000'000 + 654'321 - 5);
        EXPECT_LE(now, tick * 1'000'000 + 654'321 + 20);
    }
}

TEST_F(ControlClockTest, IsRightWithTheNeighboursOfTheTick) {
    ASSERT_TRUE(clock.start(-1'000'000));
    machine.advance_to(counter.started_ns() + 61'000'000);
    for (const std::int64_t tick : {59, 60, 61, 4000}) {
        EXPECT_NEAR(static_cast<double>(clock.now_ns(tick)), 60'000'000.0, 100.0) << tick;
    }
}

TEST_F(ControlClockTest, ASecondStartBeginsAnew) {
    ASSERT_TRUE(clock.start(0));
    machine.advance_to(machine.now_ns() + 5'000'000);
    ASSERT_TRUE(clock.start(3'000'000));
    EXPECT_NEAR(static_cast<double>(clock.now_ns(3)), 3'000'000.0, 100.0);
}

TEST_F(ControlClockTest, TellsThatTheCounterStands) {
    counter.stop();
    EXPECT_FALSE(clock.start(0));
}

}  // namespace
}  // namespace sc::stm32h743
