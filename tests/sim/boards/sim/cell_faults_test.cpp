// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "cell_job.hpp"
#include "test_host.hpp"

namespace sc::sim {
namespace {

struct Provoked {
    const char* script;
    State state;
    Fault fault;
    std::int64_t most_ns;  ///< from the edge to the last light
    int ticks = 2000;      ///< within which the state is reached
};

class SimCellFault : public testing::TestWithParam<Provoked> {};

TEST_P(SimCellFault, EndsInItsStateWithTheLaserOffInTime) {
    const Provoked& expected = GetParam();
    SimCell cell(default_cell(expected.script));
    TestHost host(cell);
    ASSERT_TRUE(host.prepare());
    const LineJob job{0.100, 0.050};
    ASSERT_TRUE(host.begin(job.items()));
    for (int i = 0; i < 20'000 && cell.plant().fault_records().empty(); ++i) {
        host.stream(40);
        host.live(1);
    }
    ASSERT_EQ(cell.plant().fault_records().size(), 1U);
    EXPECT_TRUE(host.live_until(expected.state, expected.ticks)) << name_of(cell.state());
    const std::uint64_t pulses = cell.plant().pulses();
    host.live(300);
    EXPECT_EQ(cell.plant().pulses(), pulses) << "no light at rest";
    EXPECT_LT(pulses, job.pulses());

    const CellReport report = cell.report();
    EXPECT_EQ(report.first_fault, expected.fault);
    const FaultRecord& record = report.script_events.at(0);
    if (record.last_pulse_ns) {
        EXPECT_LE(*record.last_pulse_ns - record.t_ns, expected.most_ns);
    }
}

INSTANTIATE_TEST_SUITE_P(
    Events, SimCellFault,
    testing::Values(Provoked{"pulse 500 estop open", State::fault, Fault::estop_open, 1'000},
                    Provoked{"pulse 500 interlock open", State::fault, Fault::interlock_open, 1'000},
                    Provoked{"pulse 500 laser alarm", State::fault, Fault::laser_alarm, 110'000},
                    Provoked{"pulse 500 galvo fail", State::fault, Fault::galvo_not_ready, 110'000},
                    Provoked{"pulse 500 drive x fault 0x2310", State::fault, Fault::drive_fault, 10'000'000},
                    Provoked{"pulse 500 drive x freeze", State::fault, Fault::encoder_frozen, 60'000'000},
                    Provoked{"pulse 500 drive x stall", State::fault, Fault::following_error, 60'000'000},
                    Provoked{"pulse 500 drive z silent", State::fault, Fault::drive_lost, 60'000'000},
                    Provoked{"pulse 500 link cut", State::held_link, Fault::none, 140'000'000}));

class SimCellFaultPlace : public testing::TestWithParam<const char*> {};

/// At whatever pulse it comes: those that the cell is certain of are on the part, and none beyond the last it may be.
TEST_P(SimCellFaultPlace, TheCellIsCertainOfNoPulseThatIsNotOnThePart) {
    for (int pulse = 500; pulse < 512; ++pulse) {
        SimCell cell(default_cell("pulse " + std::to_string(pulse) + ' ' + GetParam()));
        TestHost host(cell);
        ASSERT_TRUE(host.prepare());
        ASSERT_TRUE(host.begin(LineJob{0.100, 0.050}.items()));
        for (int i = 0; i < 20'000 && cell.state() != State::fault; ++i) {
            host.stream(40);
            host.live(1);
        }
        ASSERT_EQ(cell.state(), State::fault) << pulse;
        host.live(20);
        host.position.reset();
        host.send(link::PositionRequest{});
        host.live(50);
        ASSERT_TRUE(host.position);
        EXPECT_LE(host.position->pulses, cell.plant().pulses()) << "fault at pulse " << pulse;
        EXPECT_GE(host.position->reached_pulses, cell.plant().pulses()) << "fault at pulse " << pulse;
        EXPECT_GT(host.position->pulses + 100, cell.plant().pulses()) << "fault at pulse " << pulse;
    }
}

INSTANTIATE_TEST_SUITE_P(Each, SimCellFaultPlace,
                         testing::Values("estop open", "interlock open", "laser alarm", "galvo fail",
                                         "drive x fault 0x2310", "drive x freeze", "drive x stall", "drive x silent",
                                         "drive z silent"),
                         [](const auto& test) {
                             std::string name = test.param;
                             std::replace(name.begin(), name.end(), ' ', '_');
                             return name;
                         });

TEST(SimCellFaults, EveryFaultTimeIsNeitherZeroNorLost) {
    SimCell cell(default_cell("pulse 500 laser alarm"));
    TestHost host(cell);
    ASSERT_TRUE(host.prepare());
    ASSERT_TRUE(host.begin(LineJob{0.100, 0.050}.items()));
    for (int i = 0; i < 20'000 && cell.state() != State::fault; ++i) {
        host.stream(40);
        host.live(1);
    }
    const CellReport report = cell.report();
    ASSERT_EQ(report.script_events.size(), 1U);
    EXPECT_GT(report.script_events[0].t_ns, 0);
    EXPECT_GE(report.last_pulse_ns, report.script_events[0].t_ns);
}

TEST(SimCellFaults, ACellLeftAloneComesToRest) {
    SimCell cell(default_cell());
    TestHost host(cell);
    ASSERT_TRUE(host.prepare());
    ASSERT_TRUE(host.begin(LineJob{0.100, 0.050}.items()));
    for (int i = 0; i < 20'000 && cell.plant().pulses() < 100; ++i) {
        host.stream(40);
        host.live(1);
    }
    const std::int64_t left_ns = cell.now_ns();
    cell.run_out();
    EXPECT_EQ(cell.state(), State::fault);
    EXPECT_EQ(cell.report().first_fault, Fault::link_lost);
    EXPECT_LT(cell.plant().last_pulse_ns() - left_ns, 140'000'000);
    EXPECT_LT(cell.now_ns() - left_ns, 30'000'000'000);
}

}  // namespace
}  // namespace sc::sim
