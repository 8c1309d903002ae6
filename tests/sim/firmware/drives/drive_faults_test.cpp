// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <gtest/gtest.h>

#include "drive_loop.hpp"
#include "firmware/safety/watch.hpp"

namespace sc {
namespace {

using test::DriveLoop;
using SimState = sim::DriveStates::State;

class DriveFaults : public ::testing::Test {
protected:
    void SetUp() override {
        ASSERT_TRUE(loop.run(2000, [&] { return loop.outcome.all_present; }));
        ASSERT_TRUE(loop.enable());
    }
    [[nodiscard]] AxisPositions actual() const {
        AxisPositions positions{};
        for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
            positions[axis] = loop.outcome.axis[axis].actual;
        }
        return positions;
    }
    /// Moves x at a speed in pm per tick until the watch finds something; ticks until then, −1 if nothing.
    std::int64_t move_x_until_found(std::int64_t pm_per_tick, safety::Finding& finding) {
        safety::FollowingWatch watch(loop.machine);
        watch.restart(actual());
        for (std::int64_t i = 0; i < 500; ++i) {
            const AxisPositions last_target = loop.request.target;
            loop.request.target[0] -= pm_per_tick;
            loop.step();
            finding = watch.step(last_target, actual());
            if (finding) {
                return i;
            }
        }
        return -1;
    }
    DriveLoop loop;
};

TEST_F(DriveFaults, FaultOfADriveIsReportedWithItsCode) {
    loop.drives[2].raise_fault(0x3210);
    EXPECT_TRUE(loop.run(100, [&] { return loop.outcome.axis[2].fault; }));
    EXPECT_EQ(loop.outcome.axis[2].error_code, 0x3210);
    EXPECT_FALSE(loop.outcome.axis[2].enabled);
    EXPECT_FALSE(loop.outcome.axis[2].follows);
    EXPECT_FALSE(loop.outcome.all_enabled);
    EXPECT_TRUE(loop.outcome.axis[1].enabled);
    EXPECT_TRUE(loop.outcome.all_present);
}

TEST_F(DriveFaults, ResetOfOneTickBringsTheDriveOutOfFault) {
    loop.drives[2].raise_fault(0x3210);
    loop.request.power = false;
    ASSERT_TRUE(loop.run(100, [&] { return loop.outcome.axis[2].fault; }));
    loop.run(200);
    EXPECT_EQ(loop.drives[2].state(), SimState::fault);
    loop.request.reset = true;
    loop.run(1);
    loop.request.reset = false;
    EXPECT_TRUE(loop.run(50, [&] { return !loop.outcome.axis[2].fault; }));
    EXPECT_EQ(loop.outcome.axis[2].error_code, 0);
    EXPECT_TRUE(loop.enable());
}

TEST_F(DriveFaults, ResetDoesNotHappenByItself) {
    loop.drives[0].raise_fault(0x8611);
    loop.run(1000);
    EXPECT_EQ(loop.drives[0].state(), SimState::fault);
}

TEST_F(DriveFaults, QuickStopRampsDownAndDisables) {
    for (int i = 0; i < 200; ++i) {
        loop.request.target[0] -= 100'000'000;
        loop.step();
    }
    ASSERT_LT(loop.drives[0].true_velocity(), -0.09);
    loop.request.power = false;
    loop.request.quick_stop = true;
    const double place = loop.drives[0].true_position();
    EXPECT_TRUE(loop.run(200, [&] { return loop.outcome.all_disabled; }));
    const double way = std::abs(loop.drives[0].true_position() - place);
    // v²/2a = 1 mm at 5 m/s², and the way of a few cycles until the ramp begins.
    EXPECT_GT(way, 0.0009);
    EXPECT_LT(way, 0.0020);
}

TEST_F(DriveFaults, SilentDriveIsFreshNoMoreAtTheNextSyncAndLostSoonAfter) {
    loop.run(3);
    ASSERT_TRUE(loop.outcome.actual_fresh);
    loop.drives[3].go_silent(true);
    const std::int64_t from = loop.tick;
    ASSERT_TRUE(loop.run(10, [&] { return !loop.outcome.actual_fresh; }));
    EXPECT_LE(loop.tick - from, 5);
    ASSERT_TRUE(loop.run(100, [&] { return !loop.outcome.axis[3].present; }));
    EXPECT_LE(loop.tick - from, 16);
    EXPECT_FALSE(loop.outcome.all_present);
    EXPECT_TRUE(loop.outcome.axis[0].present);
}

TEST_F(DriveFaults, LostDriveComesBackUnhomed) {
    ASSERT_TRUE(loop.home(0x0F));
    loop.drives[0].go_silent(true);
    ASSERT_TRUE(loop.run(100, [&] { return !loop.outcome.axis[0].present; }));
    loop.drives[0].go_silent(false);
    ASSERT_TRUE(loop.run(5000, [&] { return loop.outcome.all_present; }));
    EXPECT_FALSE(loop.outcome.axis[0].homed);
    EXPECT_TRUE(loop.outcome.axis[1].homed);
}

TEST_F(DriveFaults, RestartedDriveIsSetUpAgain) {
    loop.drives[1].restart();
    ASSERT_TRUE(loop.run(100, [&] { return !loop.outcome.axis[1].present; }));
    EXPECT_TRUE(loop.run(5000, [&] { return loop.outcome.all_present; }));
}

TEST_F(DriveFaults, DriveStopsByItselfWhenTheMasterFallsSilent) {
    // No frames any more; the drive's own heartbeat consumer is the last line.
    for (std::int64_t t = 1; t <= 150; ++t) {
        loop.drives[0].step_to((loop.tick + t) * 1'000'000);
    }
    EXPECT_EQ(loop.drives[0].state(), SimState::fault);
    std::vector<DriveFrame> frames;
    loop.drives[0].drain(frames);
    const auto emergency = std::ranges::find_if(frames, [](const DriveFrame& f) { return f.id == 0x081; });
    ASSERT_NE(emergency, frames.end());
    EXPECT_EQ(emergency->data[0], 0x30);
    EXPECT_EQ(emergency->data[1], 0x81);
}

TEST_F(DriveFaults, BlockedAxisIsAFollowingErrorAtAnySpeed) {
    loop.drives[0].block(true);
    for (const std::int64_t speed : {2'000'000, 50'000'000}) {
        safety::Finding finding;
        EXPECT_GE(move_x_until_found(speed, finding), 0);
        EXPECT_EQ(finding, (safety::Finding{Fault::following_error, 0}));
        loop.request.target[0] = loop.outcome.axis[0].actual;
        loop.run(100);
        loop.request.target[0] = loop.outcome.axis[0].actual;
        loop.run(100);
    }
}

TEST_F(DriveFaults, BlockedAxisEndsInTheDrivesOwnFaultToo) {
    loop.drives[0].block(true);
    EXPECT_FALSE(loop.run(10, [&] { return loop.outcome.axis[0].fault; }));
    for (int i = 0; i < 200 && !loop.outcome.axis[0].fault; ++i) {
        loop.request.target[0] -= 100'000'000;
        loop.step();
    }
    EXPECT_TRUE(loop.outcome.axis[0].fault);
    EXPECT_EQ(loop.outcome.axis[0].error_code, 0x8611);
}

TEST_F(DriveFaults, FrozenEncoderIsFoundBeforeTheFollowingError) {
    for (const std::int64_t speed : {2'000'000, 200'000'000}) {
        DriveFaults::loop.drives[0].freeze_encoder(true);
        safety::Finding finding;
        const std::int64_t ticks = move_x_until_found(speed, finding);
        EXPECT_GE(ticks, 0);
        EXPECT_LE(ticks, 50'000'000 / speed + 12);
        EXPECT_EQ(finding, (safety::Finding{Fault::encoder_frozen, 0}));
        EXPECT_FALSE(loop.outcome.axis[0].fault);
        loop.drives[0].freeze_encoder(false);
        for (int i = 0; i < 300; ++i) {
            loop.step();
            loop.request.target[0] = loop.outcome.axis[0].actual;
        }
        ASSERT_FALSE(loop.outcome.axis[0].fault);
    }
}

TEST_F(DriveFaults, HomingWithoutReferenceFails) {
    loop.drives[0].hide_reference(true);
    loop.request.home = true;
    loop.request.home_axes = 1;
    ASSERT_TRUE(loop.run(20'000, [&] { return loop.outcome.axis[0].homing_failed; }));
    EXPECT_FALSE(loop.outcome.homing_done);
    EXPECT_FALSE(loop.outcome.axis[0].homed);
    EXPECT_TRUE(loop.outcome.axis[0].enabled);
    loop.request.home = false;
    loop.run(2);
    EXPECT_FALSE(loop.outcome.axis[0].homing_failed);
}

TEST_F(DriveFaults, FaultDuringHomingFailsIt) {
    loop.request.home = true;
    loop.request.home_axes = 0x0F;
    loop.run(60);
    loop.drives[3].raise_fault(0x2310);
    EXPECT_TRUE(loop.run(1000, [&] { return loop.outcome.axis[3].homing_failed; }));
    EXPECT_EQ(loop.outcome.axis[3].error_code, 0x2310);
}

}  // namespace
}  // namespace sc
