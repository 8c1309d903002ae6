// SPDX-License-Identifier: Apache-2.0
#include "firmware/controller/axis_follower.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sc {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr double kTick = 1e-3;

MachineConfig machine_with(FollowAxes follow) {
    MachineConfig machine = reference_machine();
    machine.galvo.follow = follow;
    for (AxisConfig& axis : machine.axis) {
        axis.encoder_counts_per_unit = 1e7;
    }
    return machine;
}

double at(const AxisFollower::Cubic& c, double u) { return c.place + u * (c.speed + u * (c.bend + u * c.twist)); }

/// Axes that go along x at 0.1 m/s, the set-points of a moving path.
AxisPositions path_at(double t) { return {static_cast<std::int64_t>(std::llround(0.1 * t * kPmPerMetre)), 0, 0, 0}; }

TEST(AxisFollower, ASampleBelongsToTheSetPointOfItsTimeLessTheLatency) {
    const MachineConfig machine = machine_with(FollowAxes::encoders);
    AxisFollower follower(machine);
    // The axis is exactly where its set-point was 4 ms ago: nothing to take up, whatever the speed.
    for (std::int64_t n = 1; n < 200; ++n) {
        const std::int64_t t_ns = n * 1'000'000 - 20'000;
        follower.take({t_ns, path_at(static_cast<double>(t_ns - 4'000'000) * 1e-9)});
        if (const auto shift = follower.step(n, n > 20, 0.26); shift && n > 60) {
            EXPECT_LT(std::abs(at(shift->x, 0.5)), 1e-10) << n;
        }
        follower.note(n, path_at(static_cast<double>(n + 1) * kTick));
    }
}

TEST(AxisFollower, TakesUpWhatTheAxesAreOffWhenTheMirrorsStand) {
    const MachineConfig machine = machine_with(FollowAxes::encoders);
    for (const std::size_t axis : {std::size_t{0}, std::size_t{2}, std::size_t{3}}) {
        AxisFollower follower(machine);
        const double per_metre = axis == 3 ? 180.0 / (kTwoPi / 2.0) / 0.26 * kNdegPerDegree : kPmPerMetre;
        const auto off = [](double t) { return 50e-6 * std::sin(kTwoPi * 20.0 * t); };
        double left = 0.0;
        double all = 0.0;
        for (std::int64_t n = 1; n < 600; ++n) {
            const double t = static_cast<double>(n) * kTick;
            AxisPositions measured{};
            measured[axis] = -std::llround(off(t) * per_metre);
            follower.take({n * 1'000'000, measured});
            const auto shift = follower.step(n, n > 20, 0.26);
            follower.note(n, {});
            for (int k = 0; shift && n > 100 && k < 100; ++k) {
                const double stands = (static_cast<double>(n + 1) + k * 0.01) * kTick + 160e-6;
                const double got = at(axis == 2 ? shift->z : shift->x, k * 0.01);
                left += (got - off(stands)) * (got - off(stands));
                all += off(stands) * off(stands);
                EXPECT_LT(std::abs(at(axis == 2 ? shift->x : shift->z, k * 0.01)), 1e-9);
            }
        }
        ASSERT_GT(all, 0.0);
        EXPECT_LT(std::sqrt(left / all), 0.03) << axis;
    }
}

TEST(AxisFollower, StaysWithinItsBoundAndTheMirrorsLimitsWhateverTheEncodersSay) {
    const MachineConfig machine = machine_with(FollowAxes::encoders);
    AxisFollower follower(machine);
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> any(-1e-3, 1e-3);
    std::vector<double> x;
    for (std::int64_t n = 1; n < 3000; ++n) {
        const double jump = any(random);
        follower.take({n * 1'000'000, {std::llround(jump * kPmPerMetre), 0, 0, 0}});
        const auto shift = follower.step(n, n % 500 > 100, 0.26);
        follower.note(n, {});
        for (int k = 0; k < 100; ++k) {
            x.push_back(shift ? at(shift->x, k * 0.01) : 0.0);
        }
    }
    const double frame = 1e-5;
    double most = 0.0;
    double speed = 0.0;
    double acceleration = 0.0;
    double jerk = 0.0;
    for (std::size_t i = 3; i < x.size(); ++i) {
        most = std::max(most, std::abs(x[i]));
        speed = std::max(speed, std::abs(x[i] - x[i - 1]) / frame);
        acceleration = std::max(acceleration, std::abs(x[i] - 2 * x[i - 1] + x[i - 2]) / (frame * frame));
        jerk = std::max(jerk, std::abs(x[i] - 3 * x[i - 1] + 3 * x[i - 2] - x[i - 3]) / (frame * frame * frame));
    }
    EXPECT_GT(most, 0.1e-3);
    EXPECT_LT(most, 1.3 * AxisFollower::kBound);
    EXPECT_LT(speed, machine.galvo.speed.si());
    EXPECT_LT(acceleration, machine.galvo.acceleration.si());
    EXPECT_LT(jerk, 1.01 * machine.galvo.jerk.si());
}

TEST(AxisFollower, GoesBackToRestWhenDarkOrWithoutSamples) {
    const MachineConfig machine = machine_with(FollowAxes::drives);
    AxisFollower follower(machine);
    const auto run = [&](std::int64_t from, std::int64_t to, bool samples, bool marking) {
        bool moving = false;
        for (std::int64_t n = from; n < to; ++n) {
            if (samples && n % 2 == 0) {
                follower.take({(n - 1) * 1'000'000, {-40'000'000, 0, 0, 0}});
            }
            moving = follower.step(n, marking, 0.26).has_value();
            follower.note(n, {});
        }
        return moving;
    };
    EXPECT_FALSE(run(1, 50, true, false)) << "dark";
    EXPECT_TRUE(run(50, 100, true, true));
    EXPECT_NEAR(follower.x(), 40e-6, 1e-9);
    EXPECT_FALSE(run(100, 150, true, false)) << "dark again";
    EXPECT_EQ(follower.x(), 0.0);
    EXPECT_TRUE(run(150, 200, true, true));
    EXPECT_FALSE(run(200, 260, false, true)) << "drives that say nothing";
}

}  // namespace
}  // namespace sc
