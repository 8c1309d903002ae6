// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/cell/board_cell.hpp"

#include <gtest/gtest.h>

#include "tests/sim/boards/sim/cell_job.hpp"
#include "tests/sim/boards/sim/test_host.hpp"

namespace sc::stm32h743::cell {
namespace {

using sim::LineJob;

const sim::WorldSpec& world() {
    static const sim::WorldSpec spec = sim::read_world_spec(sim::default_cell().world);
    return spec;
}

/// The same job in the simulated cell.
sim::CellReport simulated(const std::vector<Item>& items) {
    sim::SimCell cell(sim::default_cell());
    sim::BasicTestHost<sim::SimCell> host(cell);
    EXPECT_TRUE(host.prepare());
    EXPECT_TRUE(host.run(items, 20'000));
    return cell.report();
}

void expect_clean(const BoardCellReport& report) {
    EXPECT_EQ(report.frames_wrong, 0U);
    EXPECT_EQ(report.triggers_wrong, 0U);
    EXPECT_EQ(report.power_wrong, 0U);
    EXPECT_EQ(report.lines_wrong, 0U);
    EXPECT_EQ(report.unsent, 0U);
    EXPECT_EQ(report.bus_errors, 0U);
    EXPECT_FALSE(report.failed);
    EXPECT_EQ(report.violations, "");
    EXPECT_EQ(report.events.laser.wrong_power, 0U);
    EXPECT_EQ(report.events.gaps, 0U);
}

void same_as_simulated(const std::vector<Item>& items, bool fd) {
    const sim::CellReport expected = simulated(items);
    BoardCell cell(world(), {.host_fd = fd});
    sim::BasicTestHost<BoardCell> host(cell);
    ASSERT_TRUE(host.prepare());
    ASSERT_TRUE(host.run(items, 20'000));
    host.live(5);
    const BoardCellReport report = cell.report();
    expect_clean(report);
    EXPECT_EQ(report.pulses, expected.pulses);
    EXPECT_EQ(report.events.pulses, expected.pulses);
    EXPECT_GE(report.triggers, report.pulses);
    EXPECT_EQ(report.events.command_trace_sha256, expected.command_trace_sha256);
    EXPECT_EQ(report.events.set_point_sha256, expected.set_point_sha256);
    EXPECT_EQ(report.events.laser_sha256, expected.laser_sha256);
}

TEST(BoardCell, AJobOverTwoBusesGivesThePulsesAndSetPointsOfTheSimulatedCell) {
    same_as_simulated(LineJob{}.items(), true);
}

TEST(BoardCell, TheSameOverClassicFrames) { same_as_simulated(LineJob{.length = 0.002}.items(), false); }

TEST(BoardCell, AnotherJobGivesOtherHashes) {
    const sim::CellReport one = simulated(LineJob{.length = 0.002}.items());
    const sim::CellReport other = simulated(LineJob{.length = 0.0022}.items());
    EXPECT_NE(one.command_trace_sha256, other.command_trace_sha256);
    EXPECT_NE(one.laser_sha256, other.laser_sha256);
}

/// A line that is being burnt.
class MarkingOnBoard : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_TRUE(host_.prepare());
        ASSERT_TRUE(host_.begin(LineJob{}.items()));
        for (int i = 0; i < 20'000 && cell_.pulses() < 100; ++i) {
            host_.stream(40);
            host_.live(1);
        }
        ASSERT_EQ(cell_.state(), State::marking);
    }
    void expect_dark_and(Fault fault, int ticks, std::uint64_t most_pulses) {
        const std::uint64_t before = cell_.pulses();
        host_.live(ticks);
        EXPECT_EQ(cell_.controller().first_fault().fault, fault);
        EXPECT_EQ(cell_.state(), State::fault);
        EXPECT_LE(cell_.pulses(), before + most_pulses);
        const std::uint64_t pulses = cell_.pulses();
        host_.live(200);
        EXPECT_EQ(cell_.pulses(), pulses);
        EXPECT_EQ(cell_.chip().port_f.levels() & (1U << 14U), 0U) << "the shutter";
        EXPECT_EQ(cell_.chip().machine.violations_text(), "");
    }
    BoardCell cell_{world(), {}};
    sim::BasicTestHost<BoardCell> host_{cell_};
};

TEST_F(MarkingOnBoard, AnOpenEstopIsDarkAtItsEdge) {
    cell_.set_lines(false, true);
    expect_dark_and(Fault::estop_open, 2, 0);
}

TEST_F(MarkingOnBoard, AnOpenInterlockIsDarkAtItsEdge) {
    cell_.set_lines(true, false);
    expect_dark_and(Fault::interlock_open, 2, 0);
}

TEST_F(MarkingOnBoard, APulseOfTheEstopIsNotOverlooked) {
    cell_.set_lines(false, true);
    cell_.set_lines(true, true);
    expect_dark_and(Fault::estop_open, 3, 0);
}

TEST_F(MarkingOnBoard, TheBreakInputStopsTheLightWithoutTheProcessorAndIsAFault) {
    cell_.chip().tim1.set_break_pin(false);
    expect_dark_and(Fault::estop_open, 3, 0);
}

TEST_F(MarkingOnBoard, AHeadWithoutItsSupplyIsAFault) {
    cell_.head().fail(true);
    expect_dark_and(Fault::galvo_not_ready, 4, 4);
}

TEST_F(MarkingOnBoard, ADriveThatFallsSilentIsAFault) {
    cell_.drives().at(0).drive().go_silent(true);
    host_.live(12);
    EXPECT_EQ(cell_.state(), State::fault);
    EXPECT_EQ(cell_.controller().first_fault().fault, Fault::drive_lost);
}

TEST_F(MarkingOnBoard, ALateTickTurnsEverythingOffAndStarvesTheWatchdogs) {
    Chip& chip = cell_.chip();
    const std::uint64_t before = cell_.pulses();
    chip.machine.advance_to(chip.machine.now_ns() + 3'000'000);
    cell_.loop().tick();
    EXPECT_TRUE(cell_.loop().failed());
    EXPECT_FALSE(cell_.loop().plan());
    EXPECT_EQ(chip.port_f.levels() & 0xFF00U, 0U);
    // What had been laid out for the next window leaves: 2.5 pulses a window, and one that was under way.
    EXPECT_LE(cell_.seen_pulses(), before + 6);
    const std::uint64_t pulses = cell_.seen_pulses();
    chip.machine.advance_to(chip.machine.now_ns() + 20'000'000);
    cell_.loop().tick();
    EXPECT_EQ(cell_.seen_pulses(), pulses);
}

TEST_F(MarkingOnBoard, PlanningThatIsLateStarvesTheWatchdogsForThisTick) {
    Chip& chip = cell_.chip();
    const auto next = [&] { chip.machine.advance_to(chip.machine.now_ns() + 1'000'000); };
    next();
    cell_.loop().tick();
    EXPECT_TRUE(cell_.loop().plan());
    EXPECT_FALSE(cell_.loop().plan()) << "once a tick";
    next();
    cell_.loop().tick();
    next();
    EXPECT_FALSE(cell_.loop().plan());
    EXPECT_FALSE(cell_.loop().failed());
}

TEST_F(MarkingOnBoard, WithoutTicksTheGateIsShutWithTheWindowThatWasFilled) {
    Chip& chip = cell_.chip();
    chip.machine.advance_to(chip.machine.now_ns() + 1'200'000);
    (void)cell_.seen_pulses();
    chip.machine.advance_to(chip.machine.now_ns() + 50'000'000);
    const std::uint64_t pulses = cell_.seen_pulses();
    chip.machine.advance_to(chip.machine.now_ns() + 50'000'000);
    EXPECT_EQ(cell_.seen_pulses(), pulses);
    EXPECT_EQ(chip.machine.violations_text(), "");
}

}  // namespace
}  // namespace sc::stm32h743::cell
