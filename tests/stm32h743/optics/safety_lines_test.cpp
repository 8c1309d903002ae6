// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/optics/safety_lines.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "tests/stm32h743/model/external_lines.hpp"

namespace sc::stm32h743 {
namespace {

class SafetyLinesTest : public ::testing::Test {
protected:
    SafetyLinesTest() {
        machine.attach(model::ClockGates::kBase, 0x400, clocks);
        machine.attach(model::EdgePort::kBase, 0x400, port);
        machine.attach(model::EdgeLines::kBase, 0x400, edges);
        machine.attach(model::PortChoice::kBase, 0x400, choice);
        machine.attach(model::PeriodTimer::kBase, 0x400, timer);
        machine.on_interrupt(model::EdgeLines::kInterrupt5To9, [this] {
            seen.push_back(lines.edge());
            if (!port.after_read) {
                EXPECT_EQ(edges.pending(), 0U);  // or it would interrupt for ever
            }
        });
        machine.on_interrupt(model::PeriodTimer::kInterrupt, [this] { periods.push_back(lines.guard_period()); });
        edges.set_pin(7, true);
        edges.set_pin(8, true);
    }
    ~SafetyLinesTest() override { EXPECT_EQ(machine.violations_text(), ""); }
    void start() {
        machine.advance_to(5'000);
        ASSERT_TRUE(lines.start());
    }
    void after_start(std::int64_t ns) {
        machine.advance_to(timer.started_ns() + ns);
        ASSERT_FALSE(periods.empty());
    }
    void pin(unsigned which, bool high) {
        edges.set_pin(which, high);
        machine.advance_to(machine.now_ns());
        (void)machine.read(model::EdgePort::kBase);  // interrupts are served between accesses
        machine.write(model::EdgePort::kBase + 0x0C, machine.read(model::EdgePort::kBase + 0x0C), 4);
    }

    model::Machine machine;
    model::ClockGates clocks{machine};
    model::EdgePort port{machine, clocks};
    model::PortChoice choice{machine, clocks};
    model::EdgeLines edges{machine, choice, port};
    model::PeriodTimer timer{machine, clocks};
    SafetyLines lines;
    std::vector<SafetyLines::State> seen;
    std::vector<SafetyLines::State> periods;
};

TEST_F(SafetyLinesTest, TheGuardIsCalledTenThousandTimesASecond) {
    edges.set_pin(8, false);
    edges.set_pin(8, true);
    start();
    after_start(10'000'000);
    ASSERT_EQ(periods.size(), 100U);
    EXPECT_FALSE(periods[0].estop_closed);  // until a whole period has been watched
    for (std::size_t i = 1; i < periods.size(); ++i) {
        EXPECT_TRUE(periods[i].estop_closed && periods[i].interlock_closed) << i;
    }
    EXPECT_TRUE(seen.empty());
    EXPECT_TRUE(port.pulled_down(7) && port.pulled_down(8));
}

TEST_F(SafetyLinesTest, EachEdgeInterruptsAndOpenLinesAreSeen) {
    start();
    after_start(1'050'000);
    pin(7, false);
    ASSERT_EQ(seen.size(), 1U);
    EXPECT_FALSE(seen[0].estop_closed);
    EXPECT_TRUE(seen[0].interlock_closed);
    after_start(1'350'000);
    EXPECT_FALSE(periods.back().estop_closed);
    EXPECT_TRUE(periods.back().interlock_closed);
    pin(7, true);
    EXPECT_EQ(seen.size(), 2U);
    pin(8, false);
    ASSERT_EQ(seen.size(), 3U);
    EXPECT_FALSE(seen[2].interlock_closed);
    after_start(1'600'000);
    EXPECT_TRUE(periods.back().estop_closed);
    EXPECT_FALSE(periods.back().interlock_closed);
}

TEST_F(SafetyLinesTest, AnOpeningBetweenTwoPeriodsIsNotLost) {
    start();
    after_start(1'050'000);
    edges.set_pin(8, false);
    edges.set_pin(8, true);  // over before the interrupt is served
    pin(7, true);
    ASSERT_EQ(seen.size(), 1U);
    EXPECT_FALSE(seen[0].interlock_closed);
    after_start(1'150'000);
    EXPECT_FALSE(periods.back().interlock_closed);
    after_start(1'250'000);
    EXPECT_TRUE(periods.back().interlock_closed);
}

TEST_F(SafetyLinesTest, AnOpeningWhileTheLevelIsReadIsNotLost) {
    start();
    after_start(1'050'000);
    unsigned readings = 0;
    port.after_read = [&] {
        if (++readings == 1) {
            edges.set_pin(7, false);
            edges.set_pin(7, true);
        }
    };
    pin(7, false);  // and closed again by the first reading
    ASSERT_EQ(seen.size(), 2U);
    EXPECT_FALSE(seen.back().estop_closed);
}

TEST_F(SafetyLinesTest, OpenAtTheStartStaysOpen) {
    edges.set_pin(7, false);
    edges.set_pin(8, false);
    start();
    after_start(350'000);
    EXPECT_TRUE(seen.empty());
    EXPECT_FALSE(periods.back().estop_closed);
    EXPECT_FALSE(periods.back().interlock_closed);
}

}  // namespace
}  // namespace sc::stm32h743
