// SPDX-License-Identifier: Apache-2.0
#include "firmware/safety/frame_guard.hpp"

#include <gtest/gtest.h>

namespace sc::safety {
namespace {

constexpr auto bit(GuardCause cause) { return static_cast<std::uint8_t>(cause); }

GuardInputs good() {
    return {.digital = {.estop_closed = true,
                        .interlock_closed = true,
                        .laser_ready = true,
                        .laser_no_alarm = true,
                        .shutter_open = true,
                        .key_production = true,
                        .source_status = 0x4},
            .galvo_status = kGalvoStatusOk,
            .gate_allowed = true,
            .source = LaserSource::jpt};
}

TEST(FrameGuard, LetsAHealthyMarkingCellThrough) {
    const GuardVeto veto = frame_guard(good());
    EXPECT_FALSE(veto.close_gate);
    EXPECT_EQ(veto.causes, 0);
}

TEST(FrameGuard, ShutsWhatTheTickDidNotAllow) {
    GuardInputs inputs = good();
    inputs.gate_allowed = false;
    const GuardVeto veto = frame_guard(inputs);
    EXPECT_TRUE(veto.close_gate);
    EXPECT_EQ(veto.causes, 0) << "nothing is wrong";
}

TEST(FrameGuard, NamesEachCause) {
    struct Case {
        void (*spoil)(GuardInputs&);
        GuardCause cause;
    };
    const Case cases[]{
        {[](GuardInputs& in) { in.digital.estop_closed = false; }, GuardCause::estop},
        {[](GuardInputs& in) { in.digital.interlock_closed = false; }, GuardCause::interlock},
        {[](GuardInputs& in) { in.digital.laser_ready = false; }, GuardCause::laser_alarm},
        {[](GuardInputs& in) { in.digital.laser_no_alarm = false; }, GuardCause::laser_alarm},
        {[](GuardInputs& in) { in.digital.source_status = 0xC; }, GuardCause::laser_alarm},
        {[](GuardInputs& in) { in.galvo_status = 0; }, GuardCause::galvo},
        {[](GuardInputs& in) { in.galvo_status = kGalvoStatusOk ^ 0x0001; }, GuardCause::galvo},
    };
    for (const Case& c : cases) {
        for (const bool allowed : {false, true}) {
            GuardInputs inputs = good();
            inputs.gate_allowed = allowed;
            c.spoil(inputs);
            const GuardVeto veto = frame_guard(inputs);
            EXPECT_TRUE(veto.close_gate);
            EXPECT_EQ(veto.causes, bit(c.cause));
        }
    }
}

TEST(FrameGuard, AsksForThePositionAcknowledgeOnlyWhilePulsesMayLeave) {
    for (const std::uint16_t ack : {kGalvoAckX, kGalvoAckZ}) {
        GuardInputs inputs = good();
        inputs.galvo_status = static_cast<std::uint16_t>(kGalvoStatusOk & ~ack);
        EXPECT_EQ(frame_guard(inputs).causes, bit(GuardCause::galvo));
        inputs.gate_allowed = false;
        EXPECT_EQ(frame_guard(inputs).causes, 0) << "a mirror on its way";
    }
}

TEST(FrameGuard, AsksForShutterAndKeyOnlyWhilePulsesMayLeave) {
    struct Case {
        void (*spoil)(DigitalInputs&);
        GuardCause cause;
    };
    const Case cases[]{
        {[](DigitalInputs& in) { in.shutter_open = false; }, GuardCause::shutter},
        {[](DigitalInputs& in) { in.shutter_closed = true; }, GuardCause::shutter},
        {[](DigitalInputs& in) { in.key_production = false; }, GuardCause::key},
        {[](DigitalInputs& in) { in.key_setup = true; }, GuardCause::key},
    };
    for (const Case& c : cases) {
        GuardInputs inputs = good();
        c.spoil(inputs.digital);
        EXPECT_EQ(frame_guard(inputs).causes, bit(c.cause));
        EXPECT_TRUE(frame_guard(inputs).close_gate);
        inputs.gate_allowed = false;
        EXPECT_EQ(frame_guard(inputs).causes, 0) << "the tick watches it then";
    }
}

TEST(FrameGuard, AWarningOfTheSourceLetsPulsesPass) {
    GuardInputs inputs = good();
    inputs.digital.source_status = 0x7;
    EXPECT_FALSE(frame_guard(inputs).close_gate);
}

TEST(FrameGuard, NamesAllCausesAtOnce) {
    GuardInputs inputs;
    inputs.gate_allowed = true;
    const GuardVeto veto = frame_guard(inputs);
    EXPECT_TRUE(veto.close_gate);
    EXPECT_EQ(veto.causes, bit(GuardCause::estop) | bit(GuardCause::interlock) | bit(GuardCause::laser_alarm) |
                               bit(GuardCause::galvo) | bit(GuardCause::shutter) | bit(GuardCause::key));
}

}  // namespace
}  // namespace sc::safety
