// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/drive_states.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace sc::sim {
namespace {

using State = DriveStates::State;

DriveStates after(std::initializer_list<std::uint16_t> words) {
    DriveStates states;
    for (const std::uint16_t word : words) {
        states.control(word);
    }
    return states;
}

TEST(DriveStates, GoesUpOneStateAWord) {
    EXPECT_EQ(after({}).state(), State::switch_on_disabled);
    EXPECT_EQ(after({0x0F}).state(), State::switch_on_disabled) << "no way to skip shutdown";
    EXPECT_EQ(after({0x06}).state(), State::ready_to_switch_on);
    EXPECT_EQ(after({0x06, 0x0F}).state(), State::switched_on);
    EXPECT_EQ(after({0x06, 0x07, 0x0F}).state(), State::operation_enabled);
    EXPECT_TRUE(after({0x06, 0x07, 0x0F}).powered());
}

TEST(DriveStates, GoesDown) {
    EXPECT_EQ(after({0x06, 0x07, 0x0F, 0x07}).state(), State::switched_on);
    EXPECT_EQ(after({0x06, 0x07, 0x0F, 0x06}).state(), State::ready_to_switch_on);
    EXPECT_EQ(after({0x06, 0x07, 0x0F, 0x00}).state(), State::switch_on_disabled);
    EXPECT_EQ(after({0x06, 0x07, 0x02}).state(), State::switch_on_disabled);
}

TEST(DriveStates, QuickStopEndsDisabledAndCannotBeEnabledAgain) {
    DriveStates states = after({0x06, 0x07, 0x0F, 0x02});
    EXPECT_EQ(states.state(), State::quick_stop_active);
    EXPECT_TRUE(states.powered());
    states.control(0x0F);
    EXPECT_EQ(states.state(), State::quick_stop_active);
    states.ramp_ended();
    EXPECT_EQ(states.state(), State::switch_on_disabled);
}

TEST(DriveStates, FaultGoesThroughItsReactionWhenTheMotorRuns) {
    DriveStates states = after({0x06, 0x07, 0x0F});
    states.trip();
    EXPECT_EQ(states.state(), State::fault_reaction_active);
    states.control(0x00);
    EXPECT_EQ(states.state(), State::fault_reaction_active);
    states.ramp_ended();
    EXPECT_EQ(states.state(), State::fault);
    DriveStates idle;
    idle.trip();
    EXPECT_EQ(idle.state(), State::fault);
}

TEST(DriveStates, ResetIsAnEdge) {
    DriveStates states = after({0x80});
    states.trip();
    states.control(0x80);
    EXPECT_EQ(states.state(), State::fault) << "the bit was already set";
    states.control(0x00);
    states.control(0x80);
    EXPECT_EQ(states.state(), State::switch_on_disabled);
}

TEST(DriveStates, StatusBitsMatchTheStandardsMasks) {
    EXPECT_EQ(after({}).status_bits() & 0x4F, 0x40);
    EXPECT_EQ(after({0x06}).status_bits() & 0x6F, 0x21);
    EXPECT_EQ(after({0x06, 0x07}).status_bits() & 0x6F, 0x23);
    EXPECT_EQ(after({0x06, 0x07, 0x0F}).status_bits() & 0x6F, 0x27);
    EXPECT_EQ(after({0x06, 0x07, 0x0F, 0x02}).status_bits() & 0x6F, 0x07);
    DriveStates states = after({0x06, 0x07, 0x0F});
    states.trip();
    EXPECT_EQ(states.status_bits() & 0x4F, 0x0F);
    states.ramp_ended();
    EXPECT_EQ(states.status_bits() & 0x4F, 0x08);
}

}  // namespace
}  // namespace sc::sim
