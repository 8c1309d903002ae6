// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/system/clock_start.hpp"

#include <gtest/gtest.h>

#include "tests/stm32h743/model/clock_tree.hpp"

namespace sc::stm32h743 {
namespace {

using model::ClockTree;
using model::Machine;

/// What the registers amount to is what the plan says.
void expect(const ClockTree& tree, const Frequencies& plan) {
    EXPECT_DOUBLE_EQ(tree.core_hz(), plan.core_hz);
    EXPECT_DOUBLE_EQ(tree.hclk_hz(), plan.hclk_hz);
    for (unsigned bus = 1; bus <= 4; ++bus) {
        EXPECT_DOUBLE_EQ(tree.apb_hz(bus), plan.apb_hz) << bus;
    }
    EXPECT_DOUBLE_EQ(tree.timer_hz(1), plan.timer_hz);
    EXPECT_DOUBLE_EQ(tree.timer_hz(2), plan.timer_hz);
}

void expect_fast(Machine& machine, const ClockTree& tree) {
    const Clocks clocks = start_clocks();
    machine.advance_to(machine.now_ns() + 10'000);
    EXPECT_EQ(clocks.fault, ClockFault::none);
    EXPECT_EQ(clocks.frequencies.core_hz, 480'000'000U);
    expect(tree, clocks.frequencies);
    EXPECT_EQ(tree.scale(), 0);
    EXPECT_DOUBLE_EQ(tree.fdcan_hz(), clocks.frequencies.fdcan_hz);
    EXPECT_DOUBLE_EQ(tree.usart_hz(false), clocks.frequencies.apb_hz);
    EXPECT_DOUBLE_EQ(tree.usart_hz(true), clocks.frequencies.apb_hz);
    EXPECT_TRUE(tree.on(model::clock_fields::kHseGuard));
    EXPECT_EQ(machine.violations_text(), "");
}

TEST(ClockStart, FromResetTo480MHz) {
    Machine machine;
    const ClockTree tree(machine);
    expect_fast(machine, tree);
}

TEST(ClockStart, AgainAfterAResetThatKeptTheSupply) {
    Machine machine;
    ClockTree tree(machine);
    tree.preset(model::clock_fields::kScuEn, 0);
    expect_fast(machine, tree);
}

TEST(ClockStart, WithTheFewWaitStatesOfABootLoader) {
    Machine machine;
    ClockTree tree(machine);
    tree.preset(model::clock_fields::kLatency, 1);
    tree.preset(model::clock_fields::kWriteDelay, 1);
    expect_fast(machine, tree);
}

TEST(ClockStart, FromARunningPllOfABootLoader) {
    Machine machine;
    ClockTree tree(machine);
    tree.preset_running();
    expect_fast(machine, tree);
}

TEST(ClockStart, FromARunningPllWithTheVoltageThere) {
    Machine machine;
    ClockTree tree(machine);
    tree.preset_overdrive();
    expect_fast(machine, tree);
}

TEST(ClockStart, FromDividedHsiAndOtherTimerClocks) {
    Machine machine;
    ClockTree tree(machine);
    tree.preset(model::clock_fields::kHsiDiv, 2);
    tree.preset(model::clock_fields::kTimpre, 1);
    tree.preset(model::clock_fields::kUsart28Sel, 3);
    tree.preset(model::clock_fields::kUsart16Sel, 3);
    expect_fast(machine, tree);
}

TEST(ClockStart, FromHseByACrystalThatIsNotThere) {
    Machine machine;
    ClockTree tree(machine);
    tree.preset(model::clock_fields::kHseOn, 1);
    expect_fast(machine, tree);
}

struct Broken {
    ClockTree::Faults faults;
    ClockFault reason;
    double most_s;  ///< the wait ends by then
};

class ClockFaults : public testing::TestWithParam<Broken> {};

TEST_P(ClockFaults, LeaveTheCoreOnHsiWithTheReason) {
    Machine machine;
    const ClockTree tree(machine, GetParam().faults);
    const Clocks clocks = start_clocks();
    EXPECT_EQ(clocks.fault, GetParam().reason);
    EXPECT_EQ(clocks.frequencies.core_hz, 64'000'000U);
    EXPECT_EQ(clocks.frequencies.fdcan_hz, 0U);
    expect(tree, clocks.frequencies);
    EXPECT_FALSE(tree.on(model::clock_fields::kPll1On));
    EXPECT_FALSE(tree.on(model::clock_fields::kPll2On));
    EXPECT_LE(static_cast<double>(machine.now_ns()), GetParam().most_s * 1e9);
    EXPECT_EQ(machine.violations_text(), "");
}

// Reads take 10 ns here, and some 150 ns on the chip.
INSTANTIATE_TEST_SUITE_P(Clock, ClockFaults,
                         testing::Values(Broken{{.revision = 0x1003}, ClockFault::old_revision, 0.001},
                                         Broken{{.no_supply = true}, ClockFault::supply, 0.002},
                                         Broken{{.no_scale1 = true}, ClockFault::scale1, 0.002},
                                         Broken{{.no_scale0 = true}, ClockFault::scale0, 0.002},
                                         Broken{{.no_hse = true}, ClockFault::no_hse, 0.05},
                                         Broken{{.no_pll1 = true}, ClockFault::pll1, 0.002},
                                         Broken{{.no_pll2 = true}, ClockFault::pll2, 0.002},
                                         Broken{{.no_switch = true}, ClockFault::switch_over, 0.002}));

TEST(ClockStart, StaysOnHsiWhenTheFlashTakesNoWaitStates) {
    Machine machine;
    ClockTree tree(machine, {.deaf_flash = true});
    tree.preset(model::clock_fields::kLatency, 1);
    const Clocks clocks = start_clocks();
    EXPECT_EQ(clocks.fault, ClockFault::wait_states);
    expect(tree, clocks.frequencies);
    EXPECT_EQ(machine.violations_text(), "");
}

TEST(ClockStart, RefusesASupplyThatWasSetToBypass) {
    Machine machine;
    ClockTree tree(machine);
    tree.preset(model::clock_fields::kScuEn, 0);
    tree.preset(model::clock_fields::kLdoEn, 0);
    tree.preset(model::clock_fields::kBypass, 1);
    EXPECT_EQ(start_clocks().fault, ClockFault::supply);
    EXPECT_EQ(machine.violations_text(), "");
}

TEST(ClockStart, TellsWhenNotEvenHsiCanBeHad) {
    Machine machine;
    ClockTree tree(machine, {.no_switch = true});
    tree.preset_running();
    const Clocks clocks = start_clocks();
    EXPECT_EQ(clocks.fault, ClockFault::hsi);
    EXPECT_DOUBLE_EQ(tree.core_hz(), 400e6);
    EXPECT_EQ(machine.violations_text(), "");
}

TEST(ClockPlan, WaitStatesRiseWithTheFrequencyWithoutGaps) {
    std::uint32_t last = 0;
    for (std::uint32_t mhz = 1; mhz <= 240; ++mhz) {
        const FlashTiming timing = flash_timing(mhz * kMhz);
        EXPECT_GE(timing.wait_states, last);
        EXPECT_LE(timing.wait_states, last + 1);
        last = timing.wait_states;
    }
    EXPECT_EQ(flash_timing(70 * kMhz + 1).wait_states, 1U);
    EXPECT_EQ(flash_timing(185 * kMhz + 1).write_delay, 2U);
    EXPECT_EQ(last, 4U);
}

}  // namespace
}  // namespace sc::stm32h743
