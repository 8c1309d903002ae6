// SPDX-License-Identifier: Apache-2.0
// The master with plans other than the plain one, against simulated drives.
#include "shared/drives/drive_plan.hpp"

#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

#include "firmware/safety/watch.hpp"
#include "tests/sim/firmware/drives/drive_loop.hpp"

namespace sc::test {
namespace {

MachineConfig at_one_kilohertz() {
    MachineConfig machine = reference_machine();
    machine.drive_cycle_ticks = 1;
    return machine;
}

DrivePlan plan_with(void (*change)(DriveOptions&, std::size_t)) {
    DrivePlan plan;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        change(plan.drive[axis], axis);
    }
    return plan;
}

std::size_t sent_with(const DriveLoop& loop, std::uint16_t id) {
    return static_cast<std::size_t>(std::ranges::count(loop.sent, id, &DriveFrame::id));
}

/// Moves all axes by a millimetre (a degree) and looks whether they come there.
void expect_moves(DriveLoop& loop) {
    const AxisPositions start = loop.request.target;
    for (int i = 1; i <= 1000; ++i) {
        for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
            loop.request.target[axis] = start[axis] + static_cast<std::int64_t>(1e-6 * units_per_base(axis)) * i;
        }
        loop.step();
        ASSERT_TRUE(loop.outcome.all_follow) << i;
        ASSERT_TRUE(loop.outcome.actual_fresh) << i;
    }
    for (int i = 0; i < 100; ++i) {
        loop.step();
    }
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const auto off = std::abs(loop.outcome.axis[axis].actual - loop.request.target[axis]);
        EXPECT_LE(static_cast<double>(off), 3.0 * loop.count_of(axis) * units_per_base(axis)) << axis;
    }
}

TEST(DrivePlans, StatusWithEverySecondSync) {
    DriveLoop loop(at_one_kilohertz(), DriveLoop::kStart,
                   plan_with([](DriveOptions& drive, std::size_t) { drive.status_every = 2; }));
    ASSERT_TRUE(loop.master.budget().has_value());
    ASSERT_TRUE(loop.enable());
    // The drives take turns: two of the four answer each SYNC.
    for (int i = 0; i < 50; ++i) {
        loop.step();
        const auto statuses = std::ranges::count_if(
            loop.received, [](const DriveFrame& frame) { return frame.id >= 0x180 && frame.id < 0x200; });
        ASSERT_EQ(statuses, 2) << i;
    }
    expect_moves(loop);
    ASSERT_TRUE(loop.home(0x0F));
}

TEST(DrivePlans, TargetsInPairs) {
    DriveLoop loop(at_one_kilohertz(), DriveLoop::kStart,
                   plan_with([](DriveOptions& drive, std::size_t) { drive.paired = true; }));
    ASSERT_TRUE(loop.master.budget().has_value());
    ASSERT_TRUE(loop.enable());
    loop.sent.clear();
    expect_moves(loop);
    EXPECT_EQ(sent_with(loop, 0x201), 1100U);
    EXPECT_EQ(sent_with(loop, 0x203), 1100U);
    EXPECT_EQ(sent_with(loop, 0x202) + sent_with(loop, 0x204), 0U);
    // Controlwords by themselves: one at most a cycle, and repeated now and then.
    const std::size_t words =
        sent_with(loop, 0x301) + sent_with(loop, 0x302) + sent_with(loop, 0x303) + sent_with(loop, 0x304);
    EXPECT_GE(words, 80U);
    EXPECT_LE(words, 96U);
    ASSERT_TRUE(loop.home(0x0F));
    loop.request.quick_stop = true;
    EXPECT_TRUE(loop.run(500, [&] { return loop.outcome.all_disabled; }));
}

TEST(DrivePlans, FaultsOfPairedDrivesAreReset) {
    DriveLoop loop(at_one_kilohertz(), DriveLoop::kStart,
                   plan_with([](DriveOptions& drive, std::size_t) { drive.paired = true; }));
    ASSERT_TRUE(loop.enable());
    loop.drives[1].raise_fault(0x2310);
    ASSERT_TRUE(loop.run(50, [&] { return loop.outcome.axis[1].fault; }));
    EXPECT_EQ(loop.outcome.axis[1].error_code, 0x2310);
    loop.request.reset = true;
    loop.step();
    loop.request.reset = false;
    EXPECT_TRUE(loop.run(200, [&] { return loop.outcome.all_follow; }));
}

TEST(DrivePlans, TwoBuses) {
    DriveLoop loop(at_one_kilohertz(), DriveLoop::kStart,
                   plan_with([](DriveOptions& drive, std::size_t axis) { drive.bus = axis % 2 == 1 ? 1 : 0; }));
    ASSERT_TRUE(loop.master.budget().has_value());
    ASSERT_TRUE(loop.enable());
    loop.sent.clear();
    expect_moves(loop);
    EXPECT_EQ(sent_with(loop, 0x080), 1100U);
    EXPECT_EQ(sent_with(loop, 0x080 | kSecondDriveBus), 1100U);
    EXPECT_EQ(sent_with(loop, 0x201), 1100U);
    EXPECT_EQ(sent_with(loop, 0x202 | kSecondDriveBus), 1100U);
    EXPECT_EQ(sent_with(loop, 0x202), 0U);
}

/// Each method ends where its switch, index or stop is; there the axis reads its home position.
TEST(DrivePlans, HomingMethods) {
    struct Way {
        int method;
        double place;
    };
    // Limit switches at −22 and +7 mm, stops 5 mm behind them, index pulses each 4 mm from 0 on, home switch at 0;
    // the axis stands at −10 mm.
    for (const Way way : {Way{19, 0.0}, Way{20, 0.0}, Way{21, 0.0}, Way{22, 0.0}, Way{17, -0.022}, Way{18, 0.007},
                          Way{1, -0.020}, Way{2, 0.004}, Way{33, -0.012}, Way{34, -0.008}, Way{35, -0.010},
                          Way{37, -0.010}, Way{-1, -0.024}, Way{-2, 0.012}, Way{-3, -0.027}, Way{-4, 0.012}}) {
        MachineConfig machine = reference_machine();
        machine.axis[0].home_position = way.place;
        DrivePlan plan;
        plan.drive[0].homing_method = static_cast<std::int8_t>(way.method);
        DriveLoop loop(machine, DriveLoop::kStart, plan, [](std::size_t axis, sim::SimDriveOptions& options) {
            if (axis == 0) {
                options.servo.reference_position = 0.0;
                options.negative_limit = -0.022;
                options.positive_limit = 0.007;
                options.index_pitch = 0.004;
            }
        });
        ASSERT_TRUE(loop.enable()) << way.method;
        ASSERT_TRUE(loop.home(1)) << way.method;
        EXPECT_TRUE(loop.outcome.axis[0].homed) << way.method;
        EXPECT_NEAR(loop.drives[0].true_position(), way.place, 3e-6) << way.method;
        EXPECT_NEAR(static_cast<double>(loop.outcome.axis[0].actual), loop.drives[0].true_position() * kPmPerMetre,
                    3.0 * kPmPerMetre * loop.count_of(0))
            << way.method;
    }
}

/// How far an axis with a weight falls when its power is taken away.
double fall(bool sequence) {
    constexpr std::size_t kZ = 2;
    DrivePlan plan;
    if (sequence) {
        plan.drive[kZ].brake_apply_ms = 60;
        plan.drive[kZ].brake_release_ms = 80;
    }
    DriveLoop loop(reference_machine(), DriveLoop::kStart, plan, [](std::size_t axis, sim::SimDriveOptions& options) {
        if (axis == kZ) {
            options.servo.gravity = 9.81;
            options.brake_ns = 50'000'000;
        }
    });
    EXPECT_TRUE(loop.enable());
    loop.run(300);
    const double before = loop.drives[kZ].true_position();
    loop.request.power = false;
    EXPECT_TRUE(loop.run(1000, [&] { return loop.outcome.all_disabled; }));
    loop.run(300);
    return before - loop.drives[kZ].true_position();
}

TEST(DrivePlans, TheBrakeHoldsAWeightBeforeThePowerGoes) {
    EXPECT_LT(std::abs(fall(true)), 2e-6);
    EXPECT_GT(fall(false), 1e-3) << "without the sequence it falls: the model is not idle";
}

TEST(DrivePlans, ATargetWaitsUntilTheBrakeIsOpen) {
    DrivePlan plan;
    plan.drive[2].brake_release_ms = 120;
    plan.drive[2].brake_apply_ms = 60;
    DriveLoop loop(reference_machine(), DriveLoop::kStart, plan, [](std::size_t axis, sim::SimDriveOptions& options) {
        options.brake_ns = axis == 2 ? 100'000'000 : 0;
    });
    loop.request.power = true;
    ASSERT_TRUE(loop.run(2000, [&] { return loop.outcome.all_enabled; }));
    int ticks = 0;
    while (!loop.outcome.all_follow && ticks < 1000) {
        loop.run(1);
        ++ticks;
    }
    EXPECT_GE(ticks, 120);
    EXPECT_LE(ticks, 200);
    expect_moves(loop);
    // Down and up again: the brake is told anew.
    loop.request.power = false;
    ASSERT_TRUE(loop.run(1000, [&] { return loop.outcome.all_disabled; }));
    ASSERT_TRUE(loop.enable());
    ASSERT_TRUE(loop.home(0x04));
}

TEST(DrivePlans, AnotherMakersDriveIsNotUsed) {
    DrivePlan plan;
    plan.drive[3].vendor = 0x2A;
    DriveLoop loop(reference_machine(), DriveLoop::kStart, plan);
    loop.run(2000);
    EXPECT_TRUE(loop.outcome.axis[0].present);
    EXPECT_FALSE(loop.outcome.axis[3].present) << "1018:1 is 0";
}

DriveLoop loop_with(const char* quirks, const MachineConfig& machine) {
    return DriveLoop(machine, DriveLoop::kStart, kPlainDrives, [quirks](std::size_t, sim::SimDriveOptions& options) {
        options.quirks = sim::drive_quirks(quirks);
    });
}

TEST(DriveQuirks, TheMasterLivesWithWhatIsAMatterOfSetUp) {
    for (const char* const quirks : {"no-6007", "no-period", "event-driven,bit-30", "infranor", "no-dummy"}) {
        DriveLoop loop = loop_with(quirks, reference_machine());
        ASSERT_TRUE(loop.enable()) << quirks;
        expect_moves(loop);
        ASSERT_TRUE(loop.home(0x0F)) << quirks;
    }
}

TEST(DriveQuirks, ASyncOffsetOf150MicrosecondsIsLatencyAlone) {
    DriveLoop loop = loop_with("lenze-9400", reference_machine());
    ASSERT_TRUE(loop.enable());
    expect_moves(loop);
}

TEST(DriveQuirks, ADriveThatTakesATargetEach4msWantsACycleOf4ms) {
    MachineConfig machine = reference_machine();
    machine.drive_cycle_ticks = 4;
    for (AxisConfig& axis : machine.axis) {
        axis.latency_ns = 6'800'000;
    }
    DriveLoop slow = loop_with("lenze-931e", machine);
    ASSERT_TRUE(slow.enable());
    expect_moves(slow);
    // At 2 ms every other target is lost; the axis moves in jerks, and stands still in between.
    DriveLoop quick = loop_with("lenze-931e", reference_machine());
    ASSERT_TRUE(quick.enable());
    const std::int64_t start = quick.request.target[0];
    double jump = 0.0;
    double before = quick.drives[0].true_velocity();
    for (int i = 1; i <= 500; ++i) {
        quick.request.target[0] = start + 100'000'000LL * i;
        quick.step();
        jump = i > 100 ? std::max(jump, std::abs(quick.drives[0].true_velocity() - before)) : jump;
        before = quick.drives[0].true_velocity();
    }
    EXPECT_GT(jump, 0.02) << "m/s a tick, at 0.1 m/s";
}

TEST(DriveQuirks, TwoLostSyncsTripADelta) {
    DriveLoop loop = loop_with("delta", reference_machine());
    ASSERT_TRUE(loop.enable());
    loop.run(200);
    EXPECT_TRUE(loop.outcome.all_follow);
    // The board holds its frames back for three cycles.
    for (int i = 0; i < 8; ++i) {
        for (sim::SimDrive& drive : loop.drives) {
            drive.step_to((loop.tick + 1 + i) * 1'000'000);
        }
    }
    loop.tick += 8;
    ASSERT_TRUE(loop.run(50, [&] { return loop.outcome.axis[0].fault; }));
    EXPECT_EQ(loop.outcome.axis[0].error_code, 0x8700);
}

}  // namespace
}  // namespace sc::test
