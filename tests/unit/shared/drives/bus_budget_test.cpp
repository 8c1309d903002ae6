// SPDX-License-Identifier: Apache-2.0
#include "shared/drives/bus_budget.hpp"

#include <gtest/gtest.h>

#include "shared/drives/bus_terms.hpp"

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
    EXPECT_EQ(bus_budget(machine), std::unexpected(Refusal::drive_bus_full));
}

TEST(BusBudget, SharesOfOtherPlans) {
    EXPECT_NEAR(bus_budget(BusPlan{.axes = 3, .cycle_ns = 2'000'000})->cyclic, 0.3725, 1e-9);
    EXPECT_NEAR(bus_budget(BusPlan{.axes = 4, .cycle_ns = 4'000'000})->cyclic, 0.24375, 1e-9);
    EXPECT_NEAR(bus_budget(BusPlan{.axes = 6, .cycle_ns = 4'000'000})->cyclic, 0.35875, 1e-9);
    EXPECT_NEAR(bus_budget(BusPlan{.cycle_ns = 2'000'000, .tpdo_bytes = 8})->cyclic, 0.5275, 1e-9);
    EXPECT_FALSE(bus_budget(BusPlan{.axes = 6, .cycle_ns = 1'000'000}).has_value());
    EXPECT_FALSE(bus_budget(BusPlan{.bitrate = 500'000}).has_value()) << "fits barely without a reserve, not with it";
}

/// docs/drives.md and the bench have the same figures.
TEST(BusBudget, SharesWithRarerStatusPairsAndTwoBuses) {
    const auto share = [](BusPlan plan) {
        plan.cycle_ns = 1'000'000;
        return sum_of(bus_terms(plan).value()).cyclic;
    };
    EXPECT_NEAR(share({.axes = 3}), 0.745, 1e-9);
    EXPECT_NEAR(share({.axes = 4}), 0.975, 1e-9);
    EXPECT_NEAR(share({.axes = 6}), 1.435, 1e-9);
    EXPECT_NEAR(share({.axes = 3, .status_every = 2}), 0.5725, 1e-9);
    EXPECT_NEAR(share({.axes = 4, .status_every = 2}), 0.745, 1e-9);
    EXPECT_NEAR(share({.axes = 6, .status_every = 2}), 1.09, 1e-9);
    EXPECT_NEAR(share({.axes = 3, .paired = true}), 0.670, 1e-9);
    EXPECT_NEAR(share({.axes = 4, .paired = true}), 0.785, 1e-9);
    EXPECT_NEAR(share({.axes = 6, .paired = true}), 1.150, 1e-9);
    EXPECT_NEAR(share({.axes = 2}), 0.515, 1e-9);
}

TEST(BusBudget, FourAxesAtOneKilohertzFitInEachOfThreeWays) {
    MachineConfig machine = reference_machine();
    machine.drive_cycle_ticks = 1;
    DrivePlan rarer;
    DrivePlan paired;
    DrivePlan two_buses;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        rarer.drive[axis].status_every = 2;
        paired.drive[axis].paired = true;
        two_buses.drive[axis].bus = static_cast<std::uint8_t>(axis % 2);
    }
    // One SDO pair and one EMCY in 4 ms, 5 (3) heartbeats in 20 ms; a controlword in each cycle where targets are
    // paired.
    const double service = 405.0 / 4000.0;
    EXPECT_NEAR(bus_budget(machine, rarer)->total(), 0.745 + service + 325.0 / 20000.0, 1e-9);
    EXPECT_NEAR(bus_budget(machine, paired)->total(), 0.785 + 0.075 + service + 325.0 / 20000.0, 1e-9);
    EXPECT_NEAR(bus_budget(machine, two_buses)->total(), 0.515 + service + 195.0 / 20000.0, 1e-9);
}

/// The controller's sum and the list that people are shown are written apart.
TEST(BusBudget, IsTheSumOfItsTerms) {
    for (std::uint32_t ticks : {1U, 2U, 4U}) {
        for (unsigned variant = 0; variant < 64; ++variant) {
            MachineConfig machine = reference_machine();
            machine.drive_cycle_ticks = ticks;
            DrivePlan plan;
            for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
                plan.drive[axis].bus = (variant & 1U) != 0 && axis % 2 == 1 ? 1 : 0;
                plan.drive[axis].paired = (variant & 2U) != 0 && axis < 3;
                plan.drive[axis].status_every = static_cast<std::uint8_t>(1 + (variant >> 2U) % 16);
            }
            BusBudget fuller;
            for (std::uint8_t bus = 0; bus < kDriveBuses; ++bus) {
                const BusBudget sum = sum_of(bus_terms(machine, plan, bus).value());
                fuller = sum.total() > fuller.total() ? sum : fuller;
            }
            const auto budget = bus_budget(machine, plan);
            ASSERT_EQ(budget.has_value(), fuller.total() <= 1.0) << ticks << ' ' << variant;
            if (budget) {
                EXPECT_NEAR(budget->cyclic, fuller.cyclic, 1e-12);
                EXPECT_NEAR(budget->reserve, fuller.reserve, 1e-12);
            } else {
                EXPECT_EQ(budget.error(), Refusal::drive_bus_full);
            }
        }
    }
}

TEST(BusBudget, DrivesArePairedInTheOrderOfTheAxesOfABus) {
    DrivePlan plan;
    for (const std::size_t axis : {0U, 2U, 3U}) {
        plan.drive[axis].paired = true;
    }
    EXPECT_EQ(target_pair(plan, 0), (TargetPair{0, 2}));
    EXPECT_EQ(target_pair(plan, 2), (TargetPair{0, 2}));
    EXPECT_EQ(target_pair(plan, 3), (TargetPair{3, 3}));
    plan.drive[2].bus = 1;
    EXPECT_EQ(target_pair(plan, 0), (TargetPair{0, 3}));
    EXPECT_EQ(target_pair(plan, 2), (TargetPair{2, 2}));
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
    EXPECT_EQ(bus_budget(machine), std::unexpected(Refusal::bad_config));
    DrivePlan plan;
    plan.drive[1].bus = 2;
    EXPECT_EQ(bus_budget(reference_machine(), plan), std::unexpected(Refusal::bad_config));
    plan.drive[1] = {.status_every = 0};
    EXPECT_EQ(bus_budget(reference_machine(), plan), std::unexpected(Refusal::bad_config));
}

}  // namespace
}  // namespace sc::drives
