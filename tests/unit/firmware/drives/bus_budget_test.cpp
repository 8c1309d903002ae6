// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/bus_budget.hpp"

#include <gtest/gtest.h>

namespace sc::drives {
namespace {

TEST(BusBudget, WorstFrameLengths) {
    EXPECT_EQ(worst_frame_bits(0), 55U);
    EXPECT_EQ(worst_frame_bits(1), 65U);
    EXPECT_EQ(worst_frame_bits(2), 75U);
    EXPECT_EQ(worst_frame_bits(4), 95U);
    EXPECT_EQ(worst_frame_bits(6), 115U);
    EXPECT_EQ(worst_frame_bits(8), 135U);
}

TEST(BusBudget, ReferenceMachineTakesHalfOfTheBus) {
    const auto budget = bus_budget(reference_machine());
    ASSERT_TRUE(budget.has_value());
    // SYNC 55 + 8 PDOs of 115 bits in 2 ms at 1 Mbit/s.
    EXPECT_NEAR(budget->cyclic, 975.0 / 2000.0, 1e-12);
    // 3 frames of 135 bits in 2 ms, 5 heartbeats of 65 bits in 20 ms.
    EXPECT_NEAR(budget->reserve, 405.0 / 2000.0 + 325.0 / 20000.0, 1e-12);
}

TEST(BusBudget, FourAxesAtOneKilohertzAreRefused) {
    MachineConfig machine = reference_machine();
    machine.drive_cycle_ticks = 1;
    EXPECT_EQ(bus_budget(machine), std::unexpected(Refusal::bad_config));
}

TEST(BusBudget, SharesOfOtherPlans) {
    EXPECT_NEAR(bus_budget(BusPlan{.axes = 3, .cycle_ns = 2'000'000})->cyclic, 0.3725, 1e-9);
    EXPECT_NEAR(bus_budget(BusPlan{.axes = 4, .cycle_ns = 4'000'000})->cyclic, 0.24375, 1e-9);
    EXPECT_NEAR(bus_budget(BusPlan{.axes = 6, .cycle_ns = 4'000'000})->cyclic, 0.35875, 1e-9);
    EXPECT_NEAR(bus_budget(BusPlan{.cycle_ns = 2'000'000, .tpdo_bytes = 8})->cyclic, 0.5275, 1e-9);
    EXPECT_FALSE(bus_budget(BusPlan{.axes = 6, .cycle_ns = 1'000'000}).has_value());
    EXPECT_FALSE(bus_budget(BusPlan{.bitrate = 500'000}).has_value()) << "fits barely without a reserve, not with it";
}

TEST(BusBudget, PlansThatAreNoneAreRefused) {
    EXPECT_FALSE(bus_budget(BusPlan{.axes = 0}).has_value());
    EXPECT_FALSE(bus_budget(BusPlan{.bitrate = 0}).has_value());
    EXPECT_FALSE(bus_budget(BusPlan{.cycle_ns = 0}).has_value());
    EXPECT_FALSE(bus_budget(BusPlan{.cycle_ns = -1}).has_value());
    EXPECT_FALSE(bus_budget(BusPlan{.heartbeat_ns = 0}).has_value());
    EXPECT_FALSE(bus_budget(BusPlan{.rpdo_bytes = 9}).has_value());
    EXPECT_FALSE(bus_budget(BusPlan{.axes = 127}).has_value());
    MachineConfig machine = reference_machine();
    machine.drive_cycle_ticks = 0;
    EXPECT_FALSE(bus_budget(machine).has_value());
}

}  // namespace
}  // namespace sc::drives
