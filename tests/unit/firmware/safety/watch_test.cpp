// SPDX-License-Identifier: Apache-2.0
#include "firmware/safety/watch.hpp"

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace sc::safety {
namespace {

constexpr std::int64_t kMm = 1'000'000'000;  // pm
constexpr std::int64_t kUm = 1'000'000;      // pm

constexpr Finding found(Fault fault, Axis axis) { return {fault, static_cast<std::uint8_t>(axis)}; }

TEST(CheckTravel, AcceptsTheBordersAndRefusesBeyond) {
    const MachineConfig machine = reference_machine();
    EXPECT_FALSE(check_travel(machine, {0, 0, 0, 0}));
    EXPECT_FALSE(check_travel(machine, {-450 * kMm, 5 * kMm, 0, 365'000'000'000}));
    EXPECT_EQ(check_travel(machine, {-450 * kMm - 10 * kUm, 0, 0, 0}), found(Fault::soft_limit, Axis::x));
    EXPECT_EQ(check_travel(machine, {0, 5 * kMm + kUm, 0, 0}), found(Fault::soft_limit, Axis::y));
    EXPECT_EQ(check_travel(machine, {0, 0, -501 * kMm, 0}), found(Fault::soft_limit, Axis::z));
    EXPECT_EQ(check_travel(machine, {0, 0, 0, -365'000'001'000}), found(Fault::soft_limit, Axis::c));
}

TEST(KeepOut, FacesBelongToTheBox) {
    const KeepOut box{{-1, -2, -3}, {1, 2, 3}};
    EXPECT_TRUE(in_box(box, {1, 2, 3}));
    EXPECT_TRUE(in_box(box, {0, 0, 0}));
    EXPECT_FALSE(in_box(box, {1.0000001, 0, 0}));
    EXPECT_FALSE(in_box(box, {0, 0, -3.1}));
}

TEST(KeepOut, SegmentThroughAroundAndAlongTheBox) {
    const KeepOut box{{-1, -1, -1}, {1, 1, 1}};
    EXPECT_TRUE(segment_meets_box(box, {-5, 0, 0}, {5, 0, 0})) << "both ends outside";
    EXPECT_TRUE(segment_meets_box(box, {0, 0, 0}, {5, 0, 0})) << "starts inside";
    EXPECT_TRUE(segment_meets_box(box, {-2, 1, 0}, {2, 1, 0})) << "in a face";
    EXPECT_TRUE(segment_meets_box(box, {0, 2, 0}, {2, 0, 0})) << "touches an edge";
    EXPECT_FALSE(segment_meets_box(box, {0, 2.001, 0}, {2.001, 0, 0})) << "past an edge";
    EXPECT_FALSE(segment_meets_box(box, {2, 0, 0}, {5, 0, 0})) << "would meet it if it were longer";
    EXPECT_FALSE(segment_meets_box(box, {-2, 1.5, 0}, {2, 1.5, 0})) << "parallel, outside";
    EXPECT_TRUE(segment_meets_box(box, {0.5, 0.5, 0.5}, {0.5, 0.5, 0.5})) << "no length, inside";
    EXPECT_FALSE(segment_meets_box(box, {2, 0, 0}, {2, 0, 0})) << "no length, outside";
}

TEST(KeepOut, SegmentTestAgreesWithFineSampling) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(-2.0, 2.0);
    const KeepOut box{{-0.6, -0.4, -0.7}, {0.5, 0.8, 0.3}};
    const KeepOut grown{{-0.61, -0.41, -0.71}, {0.51, 0.81, 0.31}};
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 a{place(random), place(random), place(random)};
        const Vec3 b{place(random), place(random), place(random)};
        bool sampled = false;
        bool near = false;
        for (int k = 0; k <= 1000; ++k) {
            const Vec3 p = a + (k / 1000.0) * (b - a);
            sampled = sampled || in_box(box, p);
            near = near || in_box(grown, p);
        }
        const bool meets = segment_meets_box(box, a, b);
        hits += meets ? 1 : 0;
        ASSERT_TRUE(!sampled || meets) << i;
        ASSERT_TRUE(!meets || near) << i;
    }
    EXPECT_GT(hits, 100);
    EXPECT_LT(hits, 1900);
}

TEST(CheckKeepOut, FindsAStepThroughAVolume) {
    MachineConfig machine = reference_machine();
    machine.keep_out[0] = {{-0.1, -0.1, -0.1}, {-0.099, 0.0, 0.0}};
    machine.keep_out_count = 1;
    const AxisPositions left{-101 * kMm, -50 * kMm, -50 * kMm, 0};
    const AxisPositions right{-98 * kMm, -50 * kMm, -50 * kMm, 0};
    EXPECT_FALSE(check_keep_out(machine, left, left));
    EXPECT_EQ(check_keep_out(machine, left, right), (Finding{Fault::keep_out, kNoAxis}));
    machine.keep_out_count = 0;
    EXPECT_FALSE(check_keep_out(machine, left, right));
}

TEST(CheckTurn, NeedsYRetractedWhileCMoves) {
    const MachineConfig machine = reference_machine();
    const std::int64_t retracted = -200 * kMm;
    EXPECT_FALSE(check_turn(machine, {0, -300 * kMm, 0, 5}, {0, -301 * kMm, 0, 5})) << "C stands";
    EXPECT_FALSE(check_turn(machine, {0, retracted, 0, 5}, {0, retracted, 0, 6}));
    EXPECT_EQ(check_turn(machine, {0, retracted - kUm, 0, 5}, {0, retracted, 0, 6}),
              found(Fault::turn_not_retracted, Axis::c));
    EXPECT_EQ(check_turn(machine, {0, retracted, 0, 5}, {0, retracted - kUm, 0, 6}),
              found(Fault::turn_not_retracted, Axis::c));
}

/// An ideal cell: the encoders show the set-points of `delay` ticks ago on the drive's grid, renewed every second tick.
class IdealAxes {
public:
    explicit IdealAxes(std::size_t delay, std::int64_t offset = 0) : delay_(delay), offset_(offset) {}
    AxisPositions next(const AxisPositions& set_point) {
        past_.push_back(set_point);
        if (past_.size() % 2 == 0 && past_.size() > delay_) {
            const AxisPositions& p = past_[past_.size() - delay_];
            for (std::size_t i = 0; i < kAxisCount; ++i) {
                shown_[i] = (p[i] + offset_) / kUm * kUm;
            }
        }
        return shown_;
    }

private:
    std::size_t delay_;
    std::int64_t offset_;
    std::vector<AxisPositions> past_;
    AxisPositions shown_{};
};

AxisPositions oscillation(int tick) {
    const double phase = 0.01 * tick;
    const auto swing = [&](double amplitude) { return std::llround(amplitude * (1.0 - std::cos(phase))); };
    return {swing(20e9), swing(-15e9), swing(3e9), swing(4e9)};
}

TEST(FollowingWatch, IsQuietForAxesThatAreLateByTheirLatency) {
    for (const std::size_t delay : {5U, 6U, 7U, 8U}) {
        FollowingWatch watch(reference_machine());
        watch.restart({});
        IdealAxes axes(delay);
        for (int tick = 0; tick < 5000; ++tick) {
            const AxisPositions set_point = oscillation(tick);
            ASSERT_FALSE(watch.step(set_point, axes.next(set_point))) << tick;
        }
    }
}

TEST(FollowingWatch, DelaysComeFromLatencyAndDriveCycle) {
    const FollowingWatch watch(reference_machine());
    EXPECT_EQ(watch.delay_min_ticks(), 5U);
    EXPECT_EQ(watch.delay_max_ticks(), 9U);
    MachineConfig slow = reference_machine();
    slow.axis[1].latency_ns = 900'000'000;
    EXPECT_LE(FollowingWatch(slow).delay_max_ticks(), FollowingWatch::kHistory);
}

TEST(FollowingWatch, FindsAnOffsetBeyondTheWindowAtRest) {
    for (const auto& [offset_um, expected] : {std::pair{199, false}, {201, true}, {-199, false}, {-202, true}}) {
        FollowingWatch watch(reference_machine());
        watch.restart({});
        const AxisPositions actual{0, 0, offset_um * kUm, 0};
        EXPECT_EQ(watch.step({}, actual), expected ? found(Fault::following_error, Axis::z) : Finding{}) << offset_um;
    }
}

TEST(FollowingWatch, FindsAnAxisThatIsSlowerThanItsCommand) {
    FollowingWatch watch(reference_machine());
    watch.restart({});
    Finding finding;
    std::int64_t place = 0;
    for (int tick = 1; tick < 200 && !finding; ++tick) {
        place += 5 * kUm;
        finding = watch.step({place, 0, 0, 0}, {place / 10 / kUm * kUm, 0, 0, 0});
    }
    EXPECT_EQ(finding, found(Fault::following_error, Axis::x));
}

TEST(FollowingWatch, FindsAFrozenEncoderAtAnySpeed) {
    for (const std::int64_t speed : {kUm / 10, 2 * kUm, 40 * kUm, 200 * kUm}) {
        FollowingWatch watch(reference_machine());
        watch.restart({});
        IdealAxes axes(5);
        AxisPositions set_point{};
        AxisPositions frozen{};
        Finding finding;
        for (int tick = 0; tick < 2000 && !finding; ++tick) {
            set_point[1] += speed;
            const AxisPositions actual = axes.next(set_point);
            frozen = tick < 500 ? actual : frozen;
            finding = watch.step(set_point, frozen);
            ASSERT_TRUE(tick >= 500 || !finding);
        }
        EXPECT_EQ(finding, found(Fault::encoder_frozen, Axis::y)) << speed;
    }
}

TEST(FollowingWatch, StandingAxisIsNotFrozen) {
    FollowingWatch watch(reference_machine());
    watch.restart({});
    for (int tick = 0; tick < 1000; ++tick) {
        ASSERT_FALSE(watch.step({}, {}));
    }
}

TEST(FollowingWatch, LooksOnlyAtTheAxesAskedFor) {
    FollowingWatch watch(reference_machine());
    watch.restart({});
    const AxisPositions away{0, 0, 0, 90'000'000'000};
    EXPECT_FALSE(watch.step({}, away, 0x07));
    EXPECT_FALSE(watch.step(away, away, 0x0F)) << "starts where the axis stands";
    EXPECT_EQ(watch.step(away, {}, 0x0F), found(Fault::following_error, Axis::c));
}

TEST(ArithmeticState, IsRightByDefault) { EXPECT_TRUE(arithmetic_state_is_right()); }

TEST(ArithmeticState, EveryOtherRoundingIsFound) {
    for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
        ASSERT_EQ(std::fesetround(mode), 0);
        const bool right = arithmetic_state_is_right();
        std::fesetround(FE_TONEAREST);
        EXPECT_FALSE(right) << mode;
    }
}

#if defined(__SSE2__)
TEST(ArithmeticState, FlushingDenormalsIsFound) {
    constexpr unsigned kFlushToZero = 0x8000;
    constexpr unsigned kDenormalsAreZero = 0x0040;
    const unsigned before = _mm_getcsr();
    for (const unsigned mode : {kFlushToZero, kDenormalsAreZero}) {
        _mm_setcsr(before | mode);
        const bool right = arithmetic_state_is_right();
        _mm_setcsr(before);
        EXPECT_FALSE(right) << mode;
    }
}
#endif

}  // namespace
}  // namespace sc::safety
