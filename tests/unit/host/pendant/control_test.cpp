// SPDX-License-Identifier: Apache-2.0
#include "host/pendant/control.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"

namespace sc::host::pendant {
namespace {

constexpr CellView kRest{.moving = false};
constexpr CellView kMoving{.moving = true};

class PendantControlTest : public testing::Test {
protected:
    HostTime now_{std::chrono::seconds(100)};
    PendantControl control_;
    Report report_{.keys = {}, .feed = FeedKnob::mm_0_01, .axis = AxisKnob::x, .detents = 0, .proven = true};

    std::vector<Wish> send(const CellView& cell = kRest, Nanoseconds age = Nanoseconds(0)) {
        const auto bytes = to_bytes(report_, 0x5B);
        auto out = control_.take(bytes, now_, age, cell);
        report_.detents = 0;
        std::erase_if(out, [](const Wish& wish) { return wish.kind == WishKind::shown; });
        return out;
    }
    std::vector<Wish> turn(int detents, const CellView& cell = kRest, Nanoseconds age = Nanoseconds(0)) {
        report_.detents = detents;
        return send(cell, age);
    }
    std::vector<Wish> press(Key key, const CellView& cell = kRest) {
        report_.keys = {key, Key::none};
        auto out = send(cell);
        report_.keys = {};
        (void)send(cell);
        return out;
    }
    void plug() {
        control_.plugged();
        EXPECT_TRUE(send().empty());
    }
    static bool stops(const std::vector<Wish>& wishes) {
        return std::ranges::any_of(wishes, [](const Wish& wish) { return wish.kind == WishKind::stop; });
    }
    static bool jogs(const std::vector<Wish>& wishes) {
        return std::ranges::any_of(wishes, [](const Wish& wish) { return wish.kind == WishKind::jog; });
    }
};

TEST_F(PendantControlTest, ADetentMovesTheStepOfTheFeedKnob) {
    plug();
    const std::array<std::pair<FeedKnob, double>, 5> steps{{{FeedKnob::mm_0_001, 1e-6},
                                                            {FeedKnob::percent_60, 5e-6},
                                                            {FeedKnob::mm_0_01, 10e-6},
                                                            {FeedKnob::mm_0_1, 100e-6},
                                                            {FeedKnob::mm_1, 1e-3}}};
    for (const auto& [knob, step] : steps) {
        report_.feed = knob;
        EXPECT_FALSE(jogs(send()));
        const auto wishes = turn(-1);
        ASSERT_EQ(wishes.size(), 1U);
        EXPECT_EQ(wishes[0].kind, WishKind::jog);
        EXPECT_EQ(wishes[0].axis, Axis::x);
        EXPECT_DOUBLE_EQ(wishes[0].distance, -step);
    }
    report_.axis = AxisKnob::c;
    report_.feed = FeedKnob::mm_0_1;
    (void)send();
    const auto wishes = turn(2);
    ASSERT_TRUE(jogs(wishes));
    EXPECT_EQ(wishes[0].axis, Axis::c);
    EXPECT_NEAR(wishes[0].distance, 0.2, 1e-12) << "degrees";
}

TEST_F(PendantControlTest, MovesNothingWithoutAxisOrStep) {
    plug();
    for (const AxisKnob knob : {AxisKnob::off, AxisKnob::a, AxisKnob::b, AxisKnob::unknown}) {
        report_.axis = knob;
        (void)send();
        EXPECT_FALSE(jogs(turn(1)));
    }
    report_.axis = AxisKnob::y;
    report_.feed = FeedKnob::lead;
    (void)send();
    EXPECT_FALSE(jogs(turn(1)));
    EXPECT_EQ(control_.counters().unarmed, 5U);
    EXPECT_EQ(control_.counters().moved, 0U);
}

TEST_F(PendantControlTest, KeepsNothingOfWhatIsTurnedWhileTheAxisMoves) {
    plug();
    ASSERT_TRUE(jogs(turn(1)));
    for (int i = 0; i < 20; ++i) {
        EXPECT_TRUE(turn(3, kMoving).empty());
    }
    EXPECT_TRUE(control_.pass(now_, kRest).empty()) << "nothing was kept for later";
    EXPECT_EQ(control_.counters().busy, 60U);
    const auto next = turn(1);
    ASSERT_TRUE(jogs(next));
    EXPECT_DOUBLE_EQ(next[0].distance, 10e-6);
}

TEST_F(PendantControlTest, BoundsWhatOneReportMayAskFor) {
    plug();
    auto wishes = turn(127);
    ASSERT_TRUE(jogs(wishes));
    EXPECT_DOUBLE_EQ(wishes[0].distance, PendantControl::kMostDetents * 10e-6);
    EXPECT_EQ(control_.counters().beyond, 117U);
    report_.feed = FeedKnob::mm_1;
    (void)send();
    wishes = turn(-128);
    ASSERT_TRUE(jogs(wishes));
    EXPECT_DOUBLE_EQ(wishes[0].distance, -PendantControl::kMost);
}

TEST_F(PendantControlTest, TheFirstReportMovesNothing) {
    control_.plugged();
    EXPECT_FALSE(jogs(turn(1))) << "where the knobs stand was not known before";
    EXPECT_TRUE(jogs(turn(1)));
}

TEST_F(PendantControlTest, UnpluggedItStopsAndIsDeadUntilTheAxisKnobIsTurned) {
    plug();
    ASSERT_TRUE(jogs(turn(1)));
    const auto wishes = control_.unplugged(kMoving);
    ASSERT_TRUE(stops(wishes));
    EXPECT_TRUE(wishes[0].disarmed);
    EXPECT_FALSE(jogs(turn(1))) << "no device, no move";
    control_.plugged();
    (void)send();
    EXPECT_FALSE(control_.armed());
    EXPECT_FALSE(jogs(turn(1)));
    EXPECT_FALSE(jogs(turn(1)));
    report_.axis = AxisKnob::z;
    EXPECT_FALSE(jogs(turn(1, kMoving))) << "turned while the axis still comes to rest: not yet";
    report_.axis = AxisKnob::x;
    (void)send();
    EXPECT_TRUE(jogs(turn(1)));
}

TEST_F(PendantControlTest, UnpluggedItStopsThoughNothingIsKnownToMove) {
    plug();
    EXPECT_TRUE(stops(control_.unplugged(kRest))) << "a jog may be on its way";
}

TEST_F(PendantControlTest, TheKeyStopStopsAndDisarms) {
    plug();
    ASSERT_TRUE(jogs(turn(1)));
    const auto wishes = press(Key::stop, kMoving);
    ASSERT_TRUE(stops(wishes));
    EXPECT_FALSE(jogs(turn(1)));
    report_.axis = AxisKnob::off;
    (void)send();
    report_.axis = AxisKnob::x;
    (void)send();
    EXPECT_TRUE(jogs(turn(1)));
}

TEST_F(PendantControlTest, AKnobTurnedDuringAMoveStopsIt) {
    plug();
    ASSERT_TRUE(jogs(turn(1)));
    report_.feed = FeedKnob::mm_1;
    EXPECT_TRUE(stops(send(kMoving))) << "the step must not change under a move";
    (void)control_.pass(now_, kRest);
    ASSERT_TRUE(jogs(turn(1)));
    report_.axis = AxisKnob::y;
    EXPECT_TRUE(stops(send(kMoving)));
    EXPECT_FALSE(stops(send(kMoving))) << "once";
}

TEST_F(PendantControlTest, TheDeadMansSwitchEndsAMoveThatGoesOnWithoutTheWheel) {
    plug();
    ASSERT_TRUE(jogs(turn(1)));
    now_ += ControlOptions().dead_man;
    EXPECT_FALSE(stops(control_.pass(now_, kMoving)));
    EXPECT_FALSE(jogs(turn(1, kMoving)));  // turned again: alive
    now_ += ControlOptions().dead_man;
    EXPECT_FALSE(stops(control_.pass(now_, kMoving)));
    now_ += Nanoseconds(1);
    const auto wishes = control_.pass(now_, kMoving);
    ASSERT_TRUE(stops(wishes));
    EXPECT_TRUE(wishes[0].disarmed);
    EXPECT_FALSE(jogs(turn(1)));
}

TEST_F(PendantControlTest, AReportThatWaitedMovesNothing) {
    plug();
    EXPECT_FALSE(jogs(turn(1, kRest, PendantControl::kOldest + Nanoseconds(1))));
    EXPECT_EQ(control_.counters().late, 1U);
    EXPECT_TRUE(jogs(turn(1, kRest, PendantControl::kOldest)));
}

TEST_F(PendantControlTest, AWheelWithAWrongChecksumMovesNothing) {
    plug();
    report_.proven = false;
    EXPECT_FALSE(jogs(turn(1)));
    EXPECT_EQ(control_.counters().unproven, 1U);
    report_.proven = true;
    EXPECT_TRUE(jogs(turn(1)));
}

TEST_F(PendantControlTest, WithHoldFnTheWheelNeedsIt) {
    control_ = PendantControl({.steps = {}, .hold_fn = true});
    plug();
    EXPECT_FALSE(jogs(turn(1)));
    report_.keys = {Key::fn, Key::none};
    EXPECT_TRUE(jogs(turn(1)));
    EXPECT_FALSE(stops(send(kMoving)));
    report_.keys = {};
    EXPECT_TRUE(stops(send(kMoving))) << "let go";
}

TEST_F(PendantControlTest, FeedKeysChangeTheOverrideWithinItsLimits) {
    plug();
    const auto percent = [](const std::vector<Wish>& wishes) {
        return wishes.size() == 1 && wishes[0].kind == WishKind::override ? int{wishes[0].percent} : -1;
    };
    EXPECT_EQ(percent(press(Key::feed_plus, {.moving = false, .override_percent = 100})), 110);
    EXPECT_EQ(percent(press(Key::feed_plus, {.moving = false, .override_percent = 200})), 200);
    EXPECT_EQ(percent(press(Key::feed_minus, {.moving = false, .override_percent = 15})), 10);
    report_.keys = {Key::fn, Key::feed_minus};
    EXPECT_EQ(percent(send({.moving = false, .override_percent = 60})), 100);
}

TEST_F(PendantControlTest, AKeyCountsOnceAndNotIfItWasHeldWhilePluggedIn) {
    control_.plugged();
    report_.keys = {Key::start_pause, Key::none};
    EXPECT_TRUE(send().empty()) << "held from before";
    report_.keys = {};
    EXPECT_TRUE(send().empty());
    report_.keys = {Key::start_pause, Key::none};
    const auto wishes = send();
    ASSERT_EQ(wishes.size(), 1U);
    EXPECT_EQ(wishes[0].kind, WishKind::start_pause);
    EXPECT_TRUE(send().empty()) << "still held";
}

TEST_F(PendantControlTest, StopHeldWhilePluggedInStops) {
    control_.plugged();
    report_.keys = {Key::stop, Key::none};
    EXPECT_TRUE(stops(send()));
}

// Whatever comes, in whatever order: a report never asks for more than its bound, never while something moves, never
// without device, knob and step; and what was turned is accounted for, detent by detent.
TEST_F(PendantControlTest, NeverRunsAwayWhateverComes) {
    std::mt19937 random(20241);
    const auto pick = [&random](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    constexpr std::array kFeeds{FeedKnob::mm_0_001, FeedKnob::mm_1, FeedKnob::percent_60, FeedKnob::lead};
    constexpr std::array kAxes{AxisKnob::off, AxisKnob::x, AxisKnob::y, AxisKnob::c, AxisKnob::a};
    std::uint64_t turned = 0;
    bool connected = false;
    for (int i = 0; i < 200'000; ++i) {
        const CellView cell{.moving = pick(3) == 0};
        now_ += Nanoseconds(pick(300'000'000));
        std::vector<Wish> wishes;
        if (const int what = pick(40); what == 0) {
            control_.plugged();
            connected = true;
        } else if (what == 1) {
            wishes = control_.unplugged(cell);
            connected = false;
            EXPECT_TRUE(stops(wishes));
        } else if (what == 2) {
            std::vector<std::uint8_t> noise(static_cast<std::size_t>(pick(12)));
            std::ranges::generate(noise, [&] { return static_cast<std::uint8_t>(pick(256)); });
            if (const auto parsed = parse_report(noise)) {
                turned += static_cast<std::uint64_t>(std::abs(parsed->detents));
            }
            wishes = control_.take(noise, now_, Nanoseconds(0), cell);
        } else {
            report_.feed = pick(9) == 0 ? kFeeds.at(static_cast<std::size_t>(pick(4))) : report_.feed;
            report_.axis = pick(9) == 0 ? kAxes.at(static_cast<std::size_t>(pick(5))) : report_.axis;
            report_.keys = {pick(20) == 0 ? static_cast<Key>(pick(17)) : Key::none, Key::none};
            report_.detents = pick(256) - 128;
            turned += static_cast<std::uint64_t>(std::abs(report_.detents));
            wishes = control_.take(to_bytes(report_, static_cast<std::uint8_t>(pick(256))), now_,
                                   Nanoseconds(pick(400'000'000)), cell);
        }
        for (const Wish& wish : wishes) {
            if (wish.kind == WishKind::jog) {
                EXPECT_FALSE(cell.moving);
                EXPECT_TRUE(connected);
                EXPECT_TRUE(control_.armed());
                EXPECT_LE(std::abs(wish.distance),
                          (wish.axis == Axis::c ? PendantControl::kMostTurn : PendantControl::kMost) + 1e-12);
            }
        }
        EXPECT_LE(std::ranges::count_if(wishes, [](const Wish& w) { return w.kind == WishKind::jog; }), 1);
    }
    const ControlCounters& c = control_.counters();
    EXPECT_GT(c.moved, 0U);
    EXPECT_EQ(c.moved + c.busy + c.late + c.beyond + c.unarmed + c.unproven, turned);
}

TEST(PendantSteps, AreReadFromAPerson) {
    const StepTable table = step_table(std::array{1.0, 5.0, 10.0, 100.0, 1000.0});
    EXPECT_DOUBLE_EQ(table.step(FeedKnob::mm_0_01, false), 5e-6);
    EXPECT_DOUBLE_EQ(table.step(FeedKnob::percent_60, false), 1e-3);
    EXPECT_DOUBLE_EQ(table.step(FeedKnob::lead, false), 0.0);
    EXPECT_EQ(table.text(), "0.001: 1 um, 0.01: 5 um, 0.1: 10 um, 1: 100 um, 60 %: 1000 um");
    EXPECT_THROW((void)step_table(std::array{1.0, 2.0}), InputError);
    EXPECT_THROW((void)step_table(std::array{1.0, 5.0, 10.0, 100.0, 2000.0}), InputError);
    EXPECT_THROW((void)step_table(std::array{1.0, 5.0, 10.0, -1.0, 100.0}), InputError);
    EXPECT_THROW((void)step_table(std::array{1.0, 5.0, 10.0, std::nan(""), 100.0}), InputError);
}

}  // namespace
}  // namespace sc::host::pendant
