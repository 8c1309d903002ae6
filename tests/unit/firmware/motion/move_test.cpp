// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/move.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace sc::motion {
namespace {

AxisLimits limits() {
    AxisLimits l;
    l.speed = {0.2, 0.1, 0.2, 45.0};
    l.acceleration = {5.0, 2.0, 5.0, 180.0};
    l.jerk = {200.0, 100.0, 200.0, 1800.0};
    return l;
}

TEST(Move, StopsAtAnyMomentWithinTheLimitsOfEveryAxis) {
    std::mt19937_64 random(8);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    constexpr double kTick = 1e-3;
    for (int trial = 0; trial < 2000; ++trial) {
        const double reach = std::pow(10.0, -5.0 + 4.5 * std::abs(unit(random)));
        const Place from{unit(random), unit(random), unit(random), trial % 5 == 0 ? 90.0 * unit(random) : 0.0};
        Place to = from;
        if (trial % 5 == 0) {
            to[3] = 90.0 * unit(random);
        } else {
            for (std::size_t i = 0; i < 3; ++i) {
                to[i] += reach * unit(random);
            }
        }
        Move move;
        move.begin(from, to, limits(), 1e30);
        const double stop_at = move.duration() * std::abs(unit(random)) * 1.2;
        std::vector<Place> samples(3, from);
        bool stopped = false;
        for (double t = 0.0; t < 20.0; t += kTick) {
            if (!stopped && t >= stop_at) {
                move.stop(t);
                stopped = true;
            }
            samples.push_back(move.at(t));
            if (stopped && move.done(t)) {
                break;
            }
        }
        samples.insert(samples.end(), 3, samples.back());
        for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
            for (std::size_t k = 3; k < samples.size(); ++k) {
                const double a0 = samples[k][axis];
                const double a1 = samples[k - 1][axis];
                const double a2 = samples[k - 2][axis];
                const double a3 = samples[k - 3][axis];
                const AxisLimits l = limits();
                ASSERT_LE(std::abs(a0 - a1) / kTick, l.speed[axis] * 1.0001) << trial;
                ASSERT_LE(std::abs(a0 - 2 * a1 + a2) / (kTick * kTick), l.acceleration[axis] * 1.0001) << trial;
                ASSERT_LE(std::abs(a0 - 3 * a1 + 3 * a2 - a3) / (kTick * kTick * kTick), l.jerk[axis] * 1.001) << trial;
            }
        }
    }
}

TEST(Move, EndsExactlyAtItsTarget) {
    Move move;
    move.begin({0.0, 0.0, 0.0, 0.0}, {0.1, -0.05, 0.02, 0.0}, limits(), 1e30);
    EXPECT_EQ(move.at(move.duration()), (Place{0.1, -0.05, 0.02, 0.0}));
    EXPECT_FALSE(move.done(move.duration() * 0.999));
}

TEST(Move, WithoutLengthIsDoneAtOnce) {
    Move move;
    move.begin({1.0, 2.0, 3.0, 4.0}, {1.0, 2.0, 3.0, 4.0}, limits(), 1e30);
    EXPECT_TRUE(move.done(0.0));
    EXPECT_EQ(move.at(0.0), (Place{1.0, 2.0, 3.0, 4.0}));
}

}  // namespace
}  // namespace sc::motion
