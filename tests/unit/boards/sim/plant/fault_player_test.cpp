// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/fault_player.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace sc::sim {
namespace {

FaultPlayer player(const char* script) { return FaultPlayer(parse_fault_script(script, "s.txt")); }

TEST(FaultPlayer, HandsOutTimedEventsWhenDue) {
    FaultPlayer p = player("at 0.002 link restore\nat 0.001 link cut\n");
    EXPECT_EQ(p.next_time(), 1'000'000);
    EXPECT_FALSE(p.take_at(999'999));
    EXPECT_EQ(p.take_at(1'500'000)->action, FaultAction::link_cut);
    EXPECT_FALSE(p.take_at(1'500'000));
    EXPECT_EQ(p.take_at(2'000'000)->action, FaultAction::link_restore);
    EXPECT_EQ(p.next_time(), std::numeric_limits<std::int64_t>::max());
    ASSERT_EQ(p.records().size(), 2U);
    EXPECT_EQ(p.records()[0].t_ns, 1'000'000);
}

TEST(FaultPlayer, HandsOutCountedEventsAfterTheirPulse) {
    FaultPlayer p = player("pulse 10 estop open\npulse 5 interlock open\n");
    EXPECT_FALSE(p.take_after(4, 100));
    EXPECT_EQ(p.take_after(5, 200)->action, FaultAction::interlock_open);
    EXPECT_FALSE(p.take_after(9, 300));
    EXPECT_EQ(p.take_after(10, 400)->action, FaultAction::estop_open);
    EXPECT_EQ(p.records()[1].t_ns, 400);
}

TEST(FaultPlayer, RemembersTheLastPulseUntilTheCellRests) {
    FaultPlayer p = player("pulse 1 estop open\npulse 3 link cut\n");
    (void)p.take_after(1, 100);
    p.saw_pulse(100);
    EXPECT_FALSE(p.records()[0].last_pulse_ns) << "the pulse that raised it came not after it";
    p.saw_pulse(150);
    p.came_to_rest();
    p.saw_pulse(900);
    EXPECT_EQ(p.records()[0].last_pulse_ns, 150);
    (void)p.take_after(3, 1000);
    p.saw_pulse(1100);
    EXPECT_EQ(p.records()[0].last_pulse_ns, 150);
    EXPECT_EQ(p.records()[1].last_pulse_ns, 1100);
}

}  // namespace
}  // namespace sc::sim
