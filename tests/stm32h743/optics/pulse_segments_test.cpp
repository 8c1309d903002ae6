// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/optics/pulse_segments.hpp"

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/stm32h743/optics/pulse_reference.hpp"

namespace sc::stm32h743 {
namespace {

using test::expected_pulses;
using test::Pulse;
using test::random_window;

constexpr std::int64_t kTail = 100'000;

/// Plays segments as the timer does, on a clock in counts from control time 0.
struct Player {
    std::int64_t at = 0;
    std::vector<Pulse> pulses;
    std::vector<std::string> faults;

    void play(const Segment& s) {
        const std::int64_t length = std::int64_t{s.reload} + 1;
        if (length < kShortestSegment || length * (std::int64_t{s.repeats} + 1) > kLongestSegment) {
            faults.push_back("a segment of " + std::to_string(length) + " counts, " + std::to_string(s.repeats));
        }
        for (std::uint32_t i = 0; i <= s.repeats; ++i, at += length) {
            const bool open_first = s.gate_until > 0 || s.gate_from == 0;
            if (s.trigger != 0) {
                pulses.push_back({at, open_first});
            } else if (open_first) {
                faults.push_back("the gate is open without a trigger at " + std::to_string(at));
            }
            // What the trigger at the end of this one will find.
            const bool open_last = s.gate_from < length || s.gate_until >= length;
            if (i < s.repeats && open_last != open_first) {
                faults.push_back("repetitions differ at " + std::to_string(at));
            }
            const bool crosses =
                (s.gate_until > 0 && s.gate_until < 60) || (s.gate_from < length && length - s.gate_from < 60);
            if (crosses) {
                faults.push_back("the gate moves at a trigger, at " + std::to_string(at));
            }
        }
    }
};

class PulseSegmentsTest : public ::testing::Test {
protected:
    PulseSegmentsTest() { segments.begin(0); }
    void window(const std::vector<LaserRun>& runs, std::int64_t end_ns) {
        for (const LaserRun& run : runs) {
            ASSERT_TRUE(segments.add(run));
            all.push_back(run);
        }
        while (const std::optional<Segment> s = segments.next(end_ns - kTail)) {
            player.play(*s);
        }
        EXPECT_GE(player.at, (end_ns - kTail) * 6 / 25);
        EXPECT_LE(player.at, (end_ns - kTail) * 6 / 25 + kLongestSegment);
    }
    void compare() {
        EXPECT_EQ(player.faults, std::vector<std::string>{});
        const std::vector<Pulse> wanted = expected_pulses(all);
        ASSERT_EQ(player.pulses.size(), wanted.size());
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            ASSERT_EQ(player.pulses[i].count, wanted[i].count) << "trigger " << i;
            ASSERT_EQ(player.pulses[i].picked, wanted[i].picked) << "trigger " << i;
        }
        EXPECT_EQ(segments.refused(), 0U);
    }

    PulseSegments segments;
    Player player;
    std::vector<LaserRun> all;
};

TEST_F(PulseSegmentsTest, NothingToDoIsDarkToTheHorizon) {
    window({}, 1'000'000);
    window({}, 2'000'000);
    compare();
    EXPECT_TRUE(player.pulses.empty());
}

TEST_F(PulseSegmentsTest, FractionsOfACountDoNotAddUp) {
    LaserRun run;
    run.t0_ns = 1'000'003;
    run.period_ns256 = 256'000 / 3 * 2 + 77;  // 666.97 ns
    run.count = 400;
    window({}, 1'000'000);
    window({run}, 2'000'000);
    window({}, 3'000'000);
    compare();
    EXPECT_EQ(player.pulses.size(), 400U);
}

TEST_F(PulseSegmentsTest, ARunOfOnePulseNeedsNoPeriod) {
    LaserRun run;
    run.t0_ns = 1'500'000;
    run.count = 1;
    run.pick = 3;
    window({}, 1'000'000);
    window({run}, 2'000'000);
    window({}, 3'000'000);
    ASSERT_EQ(player.pulses.size(), 1U);
    EXPECT_EQ(player.pulses[0].count, 360'000);
    EXPECT_TRUE(player.pulses[0].picked);
    EXPECT_EQ(segments.refused(), 0U);
}

TEST_F(PulseSegmentsTest, PulsesThatHaveNoRoomAreLeftOutAndCounted) {
    LaserRun run;
    run.t0_ns = 1'200'000;
    run.period_ns256 = 400 * 256;  // 2.5 MHz: every second one
    run.count = 10;
    LaserRun late;
    late.t0_ns = 1'000;
    late.period_ns256 = 10'000 * 256;
    late.count = 2;
    window({}, 1'000'000);
    window({late, run}, 2'000'000);
    window({}, 3'000'000);
    EXPECT_EQ(player.pulses.size(), 5U);
    EXPECT_EQ(segments.refused(), 7U);
    EXPECT_TRUE(player.faults.empty());
}

TEST_F(PulseSegmentsTest, WhatIsDroppedNeverLeaves) {
    LaserRun run;
    run.t0_ns = 1'000'000;
    run.period_ns256 = 2'000 * 256;
    run.count = 500;
    window({}, 1'000'000);
    window({run}, 2'000'000);
    const std::size_t before = player.pulses.size();
    EXPECT_GE(before, 449U);
    segments.drop();
    window({}, 3'000'000);
    EXPECT_EQ(player.pulses.size(), before);
    EXPECT_TRUE(player.faults.empty());
}

TEST_F(PulseSegmentsTest, ALongRunIsTakenBeyondItsWindowOrRefusedWhole) {
    LaserRun run;
    run.t0_ns = 5'000'000;
    run.period_ns256 = 1'000 * 256;
    run.count = 1;
    for (std::size_t i = 0; i < 2 * kLaserRunsPerTick; ++i) {
        EXPECT_TRUE(segments.add(run));
    }
    EXPECT_FALSE(segments.add(run));
}

TEST_F(PulseSegmentsTest, EveryGapToTheNextTriggerIsMet) {
    for (std::int64_t gap = 500; gap < 120'000; gap += gap < 1'200 ? 1 : 37) {
        PulseSegments one;
        one.begin(0);
        Player alone;
        LaserRun run;
        run.t0_ns = 300'000;
        run.period_ns256 = gap * 256;
        run.count = 2;
        ASSERT_TRUE(one.add(run));
        while (const std::optional<Segment> s = one.next(900'000)) {
            alone.play(*s);
        }
        ASSERT_TRUE(alone.faults.empty()) << gap << ": " << alone.faults.front();
        const std::vector<Pulse> wanted = expected_pulses({run});
        ASSERT_EQ(alone.pulses.size(), 2U) << gap;
        ASSERT_EQ(alone.pulses[1].count, wanted[1].count) << gap;
    }
}

TEST_F(PulseSegmentsTest, RandomRunsAreMetTriggerByTrigger) {
    std::mt19937 random{5};
    std::int64_t last = 0;
    window({}, 1'000'000);
    for (std::int64_t n = 1; n < 1'500; ++n) {
        window(random_window(random, n * kWindowNs, last), (n + 1) * kWindowNs);
    }
    window({}, 1'501 * kWindowNs);
    compare();
    EXPECT_GT(player.pulses.size(), 100'000U);
}

}  // namespace
}  // namespace sc::stm32h743
