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

}  // namespace
}  // namespace sc::linux_rt
