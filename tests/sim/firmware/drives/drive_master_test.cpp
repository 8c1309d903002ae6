// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/drive_master.hpp"

#include <cmath>
#include <span>

#include <gtest/gtest.h>

#include "drive_loop.hpp"

namespace sc {
namespace {

using test::DriveLoop;

bool all_homed(const drives::Outcome& outcome) {
    return std::ranges::all_of(outcome.axis, [](const drives::AxisStatus& axis) { return axis.homed; });
}

std::int64_t sdo_requests(const std::vector<DriveFrame>& frames, std::uint16_t index) {
    return std::ranges::count_if(frames, [&](const DriveFrame& f) {
        return f.id == 0x601 && f.data[0] != 0x40 && f.data[1] == (index & 0xFF) && f.data[2] == (index >> 8);
    });
}

TEST(DriveMaster, FindsAllDrivesAfterPowerUp) {
    DriveLoop loop;
    EXPECT_TRUE(loop.run(2000, [&] { return loop.outcome.all_present; }));
    EXPECT_FALSE(loop.outcome.all_enabled);
    EXPECT_FALSE(loop.outcome.axis[0].homed);
    loop.run(4);
    EXPECT_TRUE(loop.outcome.all_disabled);
    EXPECT_TRUE(loop.outcome.actual_fresh);
}

TEST(DriveMaster, EnablesWithoutAJump) {
    DriveLoop loop;
    ASSERT_TRUE(loop.run(2000, [&] { return loop.outcome.all_present; }));
    loop.request.power = true;
    // Targets of a careless caller must not matter before `follows`.
    loop.request.target = {500'000'000'000, 500'000'000'000, 500'000'000'000, 90'000'000'000};
    for (int i = 0; i < 1000 && !loop.outcome.all_follow; ++i) {
        loop.step();
        for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
            ASSERT_NEAR(loop.drives[axis].true_position(), DriveLoop::kStart[axis], loop.count_of(axis));
        }
    }
    EXPECT_TRUE(loop.outcome.all_enabled);
    EXPECT_TRUE(loop.outcome.all_follow);
}

TEST(DriveMaster, TakesOneTransitionForEachConfirmedStatusword) {
    DriveLoop loop;
    ASSERT_TRUE(loop.run(2000, [&] { return loop.outcome.all_present; }));
    loop.sent.clear();
    ASSERT_TRUE(loop.enable());
    std::vector<int> words;
    for (const DriveFrame& frame : loop.sent) {
        if (frame.id == 0x201 && (words.empty() || words.back() != frame.data[0])) {
            words.push_back(frame.data[0]);
        }
    }
    EXPECT_EQ(words, (std::vector<int>{0x00, 0x06, 0x07, 0x0F}));
}

TEST(DriveMaster, HomesEveryAxisOntoItsHomePosition) {
    MachineConfig machine = reference_machine();
    machine.axis[0].home_position = -0.002;
    DriveLoop loop(machine);
    ASSERT_TRUE(loop.run(2000, [&] { return loop.outcome.all_present; }));
    ASSERT_TRUE(loop.enable());
    ASSERT_TRUE(loop.home(1U << index(Axis::y)));
    EXPECT_TRUE(loop.outcome.axis[index(Axis::y)].homed);
    EXPECT_FALSE(loop.outcome.axis[index(Axis::x)].homed);
    ASSERT_TRUE(loop.home(0x0D));
    EXPECT_TRUE(all_homed(loop.outcome));
    loop.run(100);
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const double home = machine.axis[axis].home_position;
        EXPECT_NEAR(loop.drives[axis].true_position(), home, loop.count_of(axis));
        EXPECT_EQ(loop.outcome.axis[axis].actual, std::llround(home * test::units_per_base(axis)));
    }
}

TEST(DriveMaster, HomingTwiceIsPossible) {
    DriveLoop loop;
    ASSERT_TRUE(loop.run(2000, [&] { return loop.outcome.all_present; }));
    ASSERT_TRUE(loop.enable());
    ASSERT_TRUE(loop.home(0x0F));
    const std::int64_t first = loop.tick;
    ASSERT_TRUE(loop.home(0x0F));
    EXPECT_GT(loop.tick - first, 20);
    EXPECT_TRUE(all_homed(loop.outcome));
}

TEST(DriveMaster, BrokenOffHomingStopsAndReturnsToCsp) {
    DriveLoop loop(reference_machine(), {-0.3, -0.3, -0.3, 100.0});
    ASSERT_TRUE(loop.run(2000, [&] { return loop.outcome.all_present; }));
    ASSERT_TRUE(loop.enable());
    loop.request.home = true;
    loop.request.home_axes = 0x0F;
    loop.run(500);
    ASSERT_GT(std::abs(loop.drives[0].true_velocity()), 0.01);
    loop.request.home = false;
    ASSERT_TRUE(loop.run(1000, [&] { return loop.outcome.all_follow; }));
    const double place = loop.drives[0].true_position();
    loop.run(200);
    EXPECT_LT(place, -0.1);
    EXPECT_NEAR(loop.drives[0].true_position(), place, 2.0 * loop.count_of(0));
    EXPECT_FALSE(loop.outcome.axis[0].homed);
    EXPECT_FALSE(loop.outcome.axis[0].homing_failed);
    EXPECT_TRUE(loop.outcome.all_enabled);
}

TEST(DriveMaster, TakesTheDrivesDownStepByStep) {
    DriveLoop loop;
    ASSERT_TRUE(loop.run(2000, [&] { return loop.outcome.all_present; }));
    ASSERT_TRUE(loop.enable());
    loop.request.power = false;
    EXPECT_TRUE(loop.run(100, [&] { return loop.outcome.all_disabled; }));
    EXPECT_EQ(loop.drives[0].state(), sim::DriveStates::State::switch_on_disabled);
    EXPECT_FALSE(loop.outcome.all_enabled);
    ASSERT_TRUE(loop.enable());
}

TEST(DriveMaster, SendsSyncRightAfterTheTargetsAndNowhereElse) {
    DriveLoop loop;
    ASSERT_TRUE(loop.run(2000, [&] { return loop.outcome.all_present; }));
    for (int i = 0; i < 50; ++i) {
        const bool cycle = loop.tick % 2 == 0;
        loop.step();
        const ServoOutputs& out = *loop.outputs;
        const auto frames = std::span(out.drive_tx).first(out.drive_tx_size);
        const auto sync = std::ranges::find_if(frames, [](const DriveFrame& f) { return f.id == 0x080; });
        if (!cycle) {
            EXPECT_EQ(sync, frames.end());
            continue;
        }
        ASSERT_EQ(sync - frames.begin(), 4);
        for (std::uint16_t axis = 0; axis < 4; ++axis) {
            EXPECT_EQ(frames[axis].id, 0x201 + axis);
        }
    }
}

TEST(DriveMaster, KeepsSdoTrafficOutOfTheTicksWithSync) {
    DriveLoop loop;
    int requests = 0;
    for (int i = 0; i < 400; ++i) {
        const bool cycle = loop.tick % 2 == 0;
        loop.step();
        for (const DriveFrame& frame : std::span(loop.outputs->drive_tx).first(loop.outputs->drive_tx_size)) {
            const bool sdo = frame.id > 0x600 && frame.id <= 0x604;
            ASSERT_FALSE(sdo && cycle) << i;
            requests += sdo ? 1 : 0;
        }
    }
    EXPECT_GT(requests, 120);
}

TEST(DriveMaster, KeepsWithinTheFramesOfATick) {
    DriveLoop loop;
    loop.run(2000);
    EXPECT_LE(loop.most_frames, 14U);
    EXPECT_GE(loop.most_frames, 5U);
}

TEST(DriveMaster, WritesAndReadsBackTheInterpolationPeriod) {
    DriveLoop loop;
    ASSERT_TRUE(loop.run(2000, [&] { return loop.outcome.all_present; }));
    EXPECT_EQ(sdo_requests(loop.sent, 0x60C2), 2);
    const auto read_back = std::ranges::count_if(loop.sent, [](const DriveFrame& f) {
        return f.id == 0x601 && f.data[0] == 0x40 && f.data[1] == 0xC2 && f.data[2] == 0x60;
    });
    EXPECT_EQ(read_back, 2);
}

TEST(DriveMaster, RefusesABusThatIsTooFull) {
    MachineConfig machine = reference_machine();
    machine.drive_cycle_ticks = 1;
    for (AxisConfig& axis : machine.axis) {
        axis.latency_ns = 4'000'000;
    }
    DriveLoop loop(machine);
    ASSERT_FALSE(loop.master.budget().has_value());
    EXPECT_EQ(loop.master.budget().error(), Refusal::drive_bus_full);
    loop.run(500);
    EXPECT_TRUE(loop.sent.empty());
    EXPECT_FALSE(loop.outcome.all_present);
}

TEST(DriveMaster, TwoRunsSendTheSameFrames) {
    const auto record = [] {
        DriveLoop loop;
        loop.run(400);
        loop.enable();
        loop.home(0x0F);
        return loop.sent;
    };
    EXPECT_EQ(record(), record());
}

}  // namespace
}  // namespace sc
