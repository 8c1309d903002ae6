// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/fault_script.hpp"

#include <gtest/gtest.h>

#include "boards/sim/world/world_error.hpp"

namespace sc::sim {
namespace {

TEST(FaultScript, ReadsEveryKindOfEvent) {
    const auto events = parse_fault_script(
        "# comment\n\n  at 3.5 estop open # here too\npulse 1000 interlock open\nat 4 drive x fault 0x2310\n"
        "at 5 drive c freeze\nat 6 drive y stall\nat 7 drive z silent\nat 8 drive z recover\nat 9 laser alarm\n"
        "at 10 laser not_ready\nat 11 laser ok\nat 12 galvo fail\nat 13 galvo ok\nat 14 link cut\n"
        "at 15 link restore\nat 16 interlock close\nat 17 estop close\nat 18 drive y fault 8977\n"
        "at 19 galvo absent\nat 20 galvo float_high\nat 21 galvo float_low\n",
        "s.txt");
    ASSERT_EQ(events.size(), 20U);
    EXPECT_EQ(events[0].after_pulse, 1000U);
    EXPECT_FALSE(events[0].at_ns);
    EXPECT_EQ(events[0].action, FaultAction::interlock_open);
    EXPECT_EQ(events[1].at_ns, 3'500'000'000);
    EXPECT_EQ(events[1].action, FaultAction::estop_open);
    EXPECT_EQ(events[1].text, "at 3.5 estop open");
    EXPECT_EQ(events[2].error_code, 0x2310);
    EXPECT_EQ(events[2].axis, Axis::x);
    EXPECT_EQ(events[3].axis, Axis::c);
    EXPECT_EQ(events[3].action, FaultAction::drive_freeze);
    EXPECT_EQ(events[12].action, FaultAction::link_cut);
    EXPECT_EQ(events[16].error_code, 8977);
    EXPECT_EQ(events[17].action, FaultAction::galvo_absent);
    EXPECT_EQ(events[18].action, FaultAction::galvo_float_high);
    EXPECT_EQ(events[19].action, FaultAction::galvo_float_low);
}

TEST(FaultScript, KnowsShutterKeyAndTheSourcesPins) {
    const auto events = parse_fault_script(
        "at 1 shutter stuck\nat 2 shutter dropped\nat 3 shutter unplugged\nat 4 shutter ok\nat 5 key off\n"
        "at 6 key setup\nat 7 key production\nat 8 laser back_reflection\nat 9 laser starting\n",
        "s.txt");
    ASSERT_EQ(events.size(), 9U);
    EXPECT_EQ(events[0].action, FaultAction::shutter_stuck);
    EXPECT_EQ(events[3].action, FaultAction::shutter_ok);
    EXPECT_EQ(events[5].action, FaultAction::key_setup);
    EXPECT_EQ(events[7].action, FaultAction::laser_back_reflection);
    EXPECT_EQ(events[8].action, FaultAction::laser_starting);
}

TEST(FaultScript, SortsByTime) {
    const auto events = parse_fault_script("at 2 link restore\nat 1 link cut\n", "s.txt");
    EXPECT_EQ(events[0].action, FaultAction::link_cut);
    EXPECT_EQ(events[1].action, FaultAction::link_restore);
}

TEST(FaultScript, EmptyIsNoEvent) { EXPECT_TRUE(parse_fault_script("\n# nothing\n", "s.txt").empty()); }

struct BadLine {
    const char* line;
    const char* value;
};
class FaultScriptRefuses : public testing::TestWithParam<BadLine> {};

TEST_P(FaultScriptRefuses, WithLineAndValue) {
    try {
        (void)parse_fault_script(std::string("at 1 link cut\n") + GetParam().line, "s.txt");
        FAIL() << "was accepted";
    } catch (const WorldError& error) {
        EXPECT_EQ(error.detail().file, "s.txt");
        EXPECT_EQ(error.detail().line, 2U);
        EXPECT_EQ(error.detail().value, GetParam().value);
    }
}
INSTANTIATE_TEST_SUITE_P(Lines, FaultScriptRefuses,
                         testing::Values(BadLine{"after 3 estop open", "after"}, BadLine{"at 3,5 estop open", "3,5"},
                                         BadLine{"at -1 estop open", "-1"}, BadLine{"at nan estop open", "nan"},
                                         BadLine{"at 1e9 estop open", "1e9"}, BadLine{"pulse 0 estop open", "0"},
                                         BadLine{"pulse 1.5 estop open", "1.5"}, BadLine{"at 1 estop", "estop"},
                                         BadLine{"at 1 estop ajar", "estop ajar"}, BadLine{"at 1 drive w freeze", "w"},
                                         BadLine{"at 1 drive x", "x"}, BadLine{"at 1 drive x fault", "fault"},
                                         BadLine{"at 1 drive x fault 0x12345", "0x12345"},
                                         BadLine{"at 1 drive x fault 0", "0"}, BadLine{"at 1 link cut now", "now"},
                                         BadLine{"at", "at"}));

TEST(FaultScript, MissingFileIsRefused) { EXPECT_THROW((void)read_fault_script("/nowhere.txt"), WorldError); }

}  // namespace
}  // namespace sc::sim
