// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/control_loop.hpp"

#include <gtest/gtest.h>

#include "boards/linux_rt/allocation_watch.hpp"
#include "boards/sim/events/event_player.hpp"
#include "rt_cell.hpp"
#include "tests/sim/boards/sim/cell_job.hpp"
#include "tests/sim/boards/sim/test_host.hpp"

namespace sc::linux_rt {
namespace {

using sim::LineJob;

const sim::WorldSpec& world() {
    static const sim::WorldSpec spec = sim::read_world_spec(sim::default_cell().world);
    return spec;
}

class LinuxLoop : public testing::Test {
protected:
    /// The same job in the simulated cell, in one process.
    static sim::OutputHashes simulated(const LineJob& job, std::uint64_t& pulses) {
        sim::OutputHashes hashes;
        sim::SimCell cell(sim::default_cell());
        struct Tapped {
            sim::SimCell* cell;
            sim::OutputHashes* hashes;
            void push_link(std::span<const std::uint8_t> bytes) const { cell->push_link(bytes); }
            std::size_t take_link(std::vector<std::uint8_t>& out) const { return cell->take_link(out); }
            void tick() const {
                cell->tick();
                hashes->tick(cell->latest());
            }
            [[nodiscard]] std::int64_t now_ns() const { return cell->now_ns(); }
            [[nodiscard]] State state() const { return cell->state(); }
            [[nodiscard]] std::uint64_t faults() const { return cell->faults(); }
        } tapped{&cell, &hashes};
        sim::BasicTestHost<Tapped> host(tapped);
        EXPECT_TRUE(host.prepare());
        EXPECT_TRUE(host.run(job.items(), 20'000));
        EXPECT_EQ(hashes.commands(), cell.report().command_trace_sha256);
        pulses = cell.plant().pulses();
        return hashes;
    }
    static void same_as_simulated(bool fd) {
        const LineJob job;
        std::uint64_t pulses = 0;
        const sim::OutputHashes expected = simulated(job, pulses);
        RtCell cell(world(), fd);
        sim::BasicTestHost<RtCell> host(cell);
        ASSERT_TRUE(host.prepare());
        ASSERT_TRUE(host.run(job.items(), 20'000));
        const sim::EventReport report = cell.player().report();
        EXPECT_EQ(report.pulses, job.pulses());
        EXPECT_EQ(pulses, job.pulses());
        EXPECT_EQ(report.gaps, 0U);
        EXPECT_EQ(report.laser.wrong_power, 0U);
        EXPECT_EQ(report.command_trace_sha256, expected.commands());
        EXPECT_EQ(report.set_point_sha256, expected.set_points());
        EXPECT_EQ(report.laser_sha256, expected.laser());
        EXPECT_EQ(cell.drives().counters().unsent, 0U);
    }
};

TEST_F(LinuxLoop, AJobOverSocketsGivesTheSetPointsAndLaserEventsOfTheSimulatedCell) { same_as_simulated(false); }

TEST_F(LinuxLoop, TheSameOverFdFrames) { same_as_simulated(true); }

TEST_F(LinuxLoop, AnotherJobGivesOtherHashes) {
    std::uint64_t pulses = 0;
    const sim::OutputHashes one = simulated({}, pulses);
    const sim::OutputHashes other = simulated({.length = 0.0202}, pulses);
    EXPECT_NE(one.commands(), other.commands());
    EXPECT_NE(one.set_points(), other.set_points());
    EXPECT_NE(one.laser(), other.laser());
}

TEST_F(LinuxLoop, NothingIsAllocatedInATickOfAJob) {
    RtCell cell(world());
    sim::BasicTestHost<RtCell> host(cell);
    ASSERT_TRUE(host.prepare());
    ASSERT_TRUE(host.begin(LineJob{}.items()));
    host.stream(40);
    cell.watch_allocations = true;
    const std::uint64_t before = forbidden_allocations();
    host.live(6000);
    EXPECT_EQ(forbidden_allocations(), before);
    EXPECT_GT(cell.pulses, 0U);
}

/// A line that is being burnt.
class MarkingOnLinux : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_TRUE(host_.prepare());
        ASSERT_TRUE(host_.begin(job_.items()));
        for (int i = 0; i < 20'000 && cell_.pulses < 100; ++i) {
            host_.stream(40);
            host_.live(1);
        }
        ASSERT_EQ(cell_.state(), State::marking);
    }
    void expect_dark_and(Fault fault, int ticks) {
        host_.live(ticks);
        EXPECT_EQ(cell_.loop().report().first_fault, fault);
        EXPECT_EQ(cell_.state(), State::fault);
        const std::uint64_t pulses = cell_.pulses;
        host_.live(200);
        EXPECT_EQ(cell_.pulses, pulses);
    }
    LineJob job_;
    RtCell cell_{world()};
    sim::BasicTestHost<RtCell> host_{cell_};
};

TEST_F(MarkingOnLinux, AnOpenInterlockStopsTheLaserInItsTickWithoutAnyEdge) {
    cell_.lines.level = static_cast<InputBits>(cell_.lines.level & ~bit(Input::interlock));
    expect_dark_and(Fault::interlock_open, 1);
    EXPECT_EQ(cell_.loop().report().lines.missed, 1U);
    EXPECT_GE(cell_.player().report().vetoes, 1U);
}

TEST_F(MarkingOnLinux, APulseOfTheEstopBetweenTwoTicksIsCaughtByItsEdge) {
    cell_.lines.fell = bit(Input::estop);
    expect_dark_and(Fault::estop_open, 1);
    EXPECT_EQ(cell_.loop().report().lines.glitches, 1U);
}

TEST_F(MarkingOnLinux, AnEventDeviceThatGoesIsAFaultAndTheLaserIsOff) {
    cell_.hang_up_events();
    host_.live(2);
    EXPECT_EQ(cell_.state(), State::fault);
    EXPECT_TRUE(cell_.events().lost());
    EXPECT_FALSE(cell_.loop().latest().gate_allowed);
    EXPECT_EQ(cell_.lines.outputs & bit(Output::shutter), 0);
}

TEST_F(MarkingOnLinux, AnAlarmThatTheEventDeviceTellsIsAFault) {
    cell_.player().alarm(true);
    expect_dark_and(Fault::laser_alarm, 2);
}

TEST_F(MarkingOnLinux, ADriveThatFallsSilentIsAFaultWithinTwoCycles) {
    cell_.bus().drive(0).go_silent(true);
    host_.live(8);
    EXPECT_EQ(cell_.state(), State::fault);
    EXPECT_EQ(cell_.loop().report().first_fault, Fault::drive_lost);
}

TEST_F(MarkingOnLinux, AskedToStopItComesToRestOffAndDark) {
    cell_.loop().stop();
    EXPECT_FALSE(cell_.loop().stopped());
    for (int i = 0; i < 1000 && !cell_.loop().stopped(); ++i) {
        host_.live(1);
    }
    EXPECT_TRUE(cell_.loop().stopped());
    EXPECT_EQ(cell_.state(), State::fault);
    const std::uint64_t pulses = cell_.pulses;
    host_.live(50);
    EXPECT_EQ(cell_.pulses, pulses);
    EXPECT_NE(cell_.bus().drive(0).state(), sim::DriveStates::State::operation_enabled);
    cell_.loop().make_safe();
    EXPECT_EQ(cell_.lines.outputs, 0);
}

TEST_F(LinuxLoop, WithoutALaserItIsHomedButNotArmed) {
    RtCell cell(world());
    sim::BasicTestHost<RtCell> host(cell);
    cell.player().alarm(true);
    ASSERT_TRUE(host.connect());
    ASSERT_TRUE(host.live_until(State::disabled, 3000));
    ASSERT_EQ(host.command(link::Verb::enable), 0);
    ASSERT_TRUE(host.live_until(State::idle, 3000));
    ASSERT_EQ(host.command(link::Verb::home), 0);
    host.live(10);
    ASSERT_TRUE(host.live_until(State::idle, 30'000));
    EXPECT_EQ(host.command(link::Verb::arm), static_cast<std::uint16_t>(Refusal::laser_not_ready));
}

TEST_F(LinuxLoop, AJobFinerThanABareGateCanPlaceIsRefusedWithItsItem) {
    MachineConfig machine = RtCell::axes_machine();
    restrict_to_gate(machine);
    RtCell cell(world(), false, machine);
    sim::BasicTestHost<RtCell> host(cell);
    ASSERT_TRUE(host.prepare());
    EXPECT_FALSE(host.run(LineJob{}.items(), 20'000));  // 20 um at 50 mm/s
    ASSERT_TRUE(host.refused);
    EXPECT_EQ(host.refused->refusal, static_cast<std::uint16_t>(Refusal::bad_pitch));
    EXPECT_EQ(cell.pulses, 0U);
}

TEST_F(LinuxLoop, AGalvoJobIsRefusedSinceThereIsNoField) {
    RtCell cell(world());
    sim::BasicTestHost<RtCell> host(cell);
    ASSERT_TRUE(host.prepare());
    std::vector<Item> items = LineJob{}.items();
    std::get<PathBegin>(items.at(1)).actuator = Actuator::galvo;
    EXPECT_FALSE(host.run(items, 20'000));
    ASSERT_TRUE(host.refused);
    EXPECT_EQ(host.refused->refusal, static_cast<std::uint16_t>(Refusal::galvo_out_of_field));
    EXPECT_EQ(cell.pulses, 0U);
}

}  // namespace
}  // namespace sc::linux_rt
