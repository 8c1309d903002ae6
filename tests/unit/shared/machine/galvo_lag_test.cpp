// SPDX-License-Identifier: Apache-2.0
#include "shared/machine/galvo_lag.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace sc {
namespace {

int fault(std::int64_t latency_ns, double frequency, double damping) {
    const MachineConfig machine = reference_machine();
    return fault_of({latency_ns, Frequency::from_si(frequency), damping}, machine.galvo, machine.galvo_period_ns);
}

TEST(GalvoLag, WhatTheMachineStatesAndWhatIsNearItIsSound) {
    const MachineConfig machine = reference_machine();
    EXPECT_EQ(fault_of(lag_of(machine.galvo), machine.galvo, machine.galvo_period_ns), 0);
    EXPECT_EQ(fault(0, 0.0, 0.0), 0) << "empty";
    EXPECT_EQ(fault(205'800, 1600.0, 0.75), 0);
    EXPECT_EQ(fault(124'000, 2400.0, 0.75), 0);
}

TEST(GalvoLag, SaysWhatIsOutOfRange) {
    EXPECT_EQ(fault(79'000, 2000.0, 0.2), 1) << "half of what is stated";
    EXPECT_EQ(fault(321'000, 2000.0, 0.75), 1);
    EXPECT_EQ(fault(-1, 2000.0, 0.75), 1);
    EXPECT_EQ(fault(160'000, 990.0, 0.3), 2);
    EXPECT_EQ(fault(160'000, 4100.0, 0.75), 2);
    EXPECT_EQ(fault(160'000, 0.0, 0.75), 2);
    EXPECT_EQ(fault(160'000, std::nan(""), 0.75), 2);
    EXPECT_EQ(fault(160'000, 2000.0, 0.05), 3);
    EXPECT_EQ(fault(160'000, 2000.0, std::nan("")), 3);
    EXPECT_EQ(fault(160'000, 1600.0, 0.9), 4) << "the servo alone is later than that";
}

TEST(GalvoLag, OfAMachineThatStatesNoServoTheRangeAloneIsAsked) {
    GalvoConfig galvo = reference_machine().galvo;
    galvo.natural_frequency = {};
    galvo.damping = 0.0;
    EXPECT_EQ(fault_of({700'000, Frequency::from_si(500.0), 0.7}, galvo, 10'000), 0);
    EXPECT_EQ(fault_of({1'100'000, Frequency::from_si(500.0), 0.7}, galvo, 10'000), 1);
    EXPECT_EQ(fault_of({700'000, Frequency::from_si(25e3), 0.7}, galvo, 10'000), 2);
}

}  // namespace
}  // namespace sc
