// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/axis402.hpp"

#include <array>

#include <gtest/gtest.h>

namespace sc::drives::axis402 {
namespace {

struct Row {
    std::uint16_t mask;
    std::uint16_t value;
    PowerState state;
};
// As the standard prints it, state by state.
constexpr std::array kRows{
    Row{0x4F, 0x00, PowerState::not_ready},
    Row{0x4F, 0x40, PowerState::switch_on_disabled},
    Row{0x6F, 0x21, PowerState::ready_to_switch_on},
    Row{0x6F, 0x23, PowerState::switched_on},
    Row{0x6F, 0x27, PowerState::operation_enabled},
    Row{0x6F, 0x07, PowerState::quick_stop_active},
    Row{0x4F, 0x0F, PowerState::fault_reaction_active},
    Row{0x4F, 0x08, PowerState::fault},
};

TEST(Axis402, DecodesEveryStatuswordAsTheStandardsTable) {
    for (unsigned word = 0; word <= 0xFFFF; ++word) {
        PowerState expected = PowerState::unknown;
        int matches = 0;
        for (const Row& row : kRows) {
            if ((word & row.mask) == row.value) {
                expected = row.state;
                ++matches;
            }
        }
        ASSERT_LE(matches, 1);
        ASSERT_EQ(decode(static_cast<std::uint16_t>(word)), expected) << word;
    }
}

TEST(Axis402, OneCommandLeadsOneStateUp) {
    EXPECT_EQ(next_controlword(PowerState::switch_on_disabled, true), 0x06);
    EXPECT_EQ(next_controlword(PowerState::ready_to_switch_on, true), 0x07);
    EXPECT_EQ(next_controlword(PowerState::switched_on, true), 0x0F);
    EXPECT_EQ(next_controlword(PowerState::operation_enabled, true), 0x0F);
}

TEST(Axis402, OneCommandLeadsOneStateDown) {
    EXPECT_EQ(next_controlword(PowerState::operation_enabled, false), 0x07);
    EXPECT_EQ(next_controlword(PowerState::switched_on, false), 0x06);
    EXPECT_EQ(next_controlword(PowerState::ready_to_switch_on, false), 0x00);
    EXPECT_EQ(next_controlword(PowerState::switch_on_disabled, false), 0x00);
}

TEST(Axis402, QuickStopIsNeverLeftByEnabling) {
    // Transition 16 exists only with 605A = 5..8; the set-up writes 2, so the drive goes to disabled by itself.
    EXPECT_EQ(next_controlword(PowerState::quick_stop_active, true), 0x02);
    EXPECT_EQ(next_controlword(PowerState::quick_stop_active, false), 0x02);
}

TEST(Axis402, FaultsAndUnknownPatternsGetNoPower) {
    for (const PowerState state :
         {PowerState::not_ready, PowerState::fault_reaction_active, PowerState::fault, PowerState::unknown}) {
        EXPECT_EQ(next_controlword(state, true), 0x00);
    }
}

TEST(Axis402, HomingBits13And12And10) {
    EXPECT_EQ(decode_homing(0x0237), HomingState::running);
    EXPECT_EQ(decode_homing(0x0237 | 0x0400), HomingState::interrupted);
    EXPECT_EQ(decode_homing(0x0237 | 0x1000), HomingState::attained_moving);
    EXPECT_EQ(decode_homing(0x0237 | 0x1400), HomingState::done);
    EXPECT_EQ(decode_homing(0x0237 | 0x2000), HomingState::error);
    EXPECT_EQ(decode_homing(0x0237 | 0x2400), HomingState::error);
}

}  // namespace
}  // namespace sc::drives::axis402
