// SPDX-License-Identifier: Apache-2.0
#include "host/path/profile.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace sc::host {
namespace {

/// Distance of the move that takes `ramp` of jerk, `hold` of constant acceleration and `cruise`, by adding up steps.
struct Summed {
    double distance = 0.0;
    double seconds = 0.0;
};
Summed summed(double ramp, double hold, double cruise, double jerk) {
    constexpr double kStep = 1e-5;
    Summed out;
    double a = 0.0;
    double v = 0.0;
    const double rise = 2.0 * ramp + hold;
    out.seconds = 2.0 * rise + cruise;
    for (double t = 0.0; t < out.seconds; t += kStep) {
        const double mirrored = t < rise + 0.5 * cruise ? t : out.seconds - t;
        const double sign = t < rise + 0.5 * cruise ? 1.0 : -1.0;
        if (mirrored < ramp) {
            a = sign * jerk * mirrored;
        } else if (mirrored < ramp + hold) {
            a = sign * jerk * ramp;
        } else if (mirrored < rise) {
            a = sign * jerk * (rise - mirrored);
        } else {
            a = 0.0;
        }
        v += a * kStep;
        out.distance += v * kStep;
    }
    return out;
}

constexpr MoveLimits kAxes{0.2, 5.0, 200.0};

TEST(MoveTime, MatchesTheSumOfAMoveThatReachesItsSpeed) {
    // 25 ms ramp to 5 m/s², 15 ms of it, 0.2 m/s.
    const Summed move = summed(0.025, 0.015, 0.4, 200.0);
    EXPECT_NEAR(move_time(move.distance, kAxes), move.seconds, 2e-4);
}

TEST(MoveTime, MatchesTheSumOfAMoveThatReachesItsAccelerationOnly) {
    const Summed move = summed(0.025, 0.005, 0.0, 200.0);
    EXPECT_NEAR(move_time(move.distance, kAxes), move.seconds, 2e-4);
}

TEST(MoveTime, MatchesTheSumOfAMoveThatReachesNoLimit) {
    const Summed move = summed(0.010, 0.0, 0.0, 200.0);
    EXPECT_NEAR(move_time(move.distance, kAxes), move.seconds, 2e-4);
}

TEST(MoveTime, IsZeroForNoMoveAndTheSameBothWays) {
    EXPECT_EQ(move_time(0.0, kAxes), 0.0);
    EXPECT_EQ(move_time(-0.1, kAxes), move_time(0.1, kAxes));
}

TEST(MoveTime, GrowsWithoutJumpsOverAllThreeRegimes) {
    double last = 0.0;
    for (double d = 1e-7; d < 0.1; d *= 1.01) {
        const double t = move_time(d, kAxes);
        EXPECT_GT(t, last);
        EXPECT_LT(t, last * 1.011 + 1e-2);
        last = t;
    }
}

TEST(MoveTime, LongMoveLosesOneSpeedUpTime) {
    EXPECT_NEAR(move_time(1.0, kAxes), 1.0 / 0.2 + 0.2 / 5.0 + 5.0 / 200.0, 1e-12);
}

TEST(SpeedUp, KeepsToJerkWhenAccelerationIsNotReached) {
    EXPECT_NEAR(speed_up_time(0.05, kAxes), 2.0 * std::sqrt(0.05 / 200.0), 1e-15);
    EXPECT_NEAR(speed_up_distance(0.05, kAxes), 0.05 * std::sqrt(0.05 / 200.0), 1e-15);
}

TEST(SpeedUp, IsContinuousWhereAccelerationIsJustReached) {
    const double v = 5.0 * 5.0 / 200.0;
    EXPECT_NEAR(speed_up_time(v * (1 - 1e-9), kAxes), speed_up_time(v * (1 + 1e-9), kAxes), 1e-9);
}

}  // namespace
}  // namespace sc::host
