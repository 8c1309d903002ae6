// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/drive_servo.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace sc::sim {
namespace {

constexpr double kStep = 50e-6;

ServoOptions frictionless() {
    ServoOptions options;
    options.friction = 0.0;
    return options;
}

TEST(Servo, LagsAtConstantSpeedByTheOptionAlone) {
    for (const double lag : {1e-3, 2e-3, 3.5e-3}) {
        for (const double step : {50e-6, 20e-6}) {
            ServoOptions options = frictionless();
            options.lag_s = lag;
            Servo servo(options, 0.0);
            servo.power(true);
            const double speed = 0.1;
            double demand = 0.0;
            for (int i = 0; i < 4000; ++i) {
                servo.step(demand + 0.5 * speed * step, step);
                demand += speed * step;
            }
            // Half a count of bias is possible where the steps and the encoder's grid beat.
            EXPECT_NEAR(demand - servo.position(), speed * lag, 0.55e-6) << lag << " " << step;
        }
    }
}

TEST(Servo, StepResponseSettlesWithinACountAndStands) {
    Servo servo(ServoOptions{}, 0.0);
    servo.power(true);
    double highest = 0.0;
    for (int i = 0; i < 2000; ++i) {
        servo.step(100e-6, kStep);
        highest = std::max(highest, servo.position());
    }
    EXPECT_NEAR(servo.position(), 100e-6, 1e-6);
    EXPECT_LT(highest, 106e-6) << "a well damped loop overshoots by 4 percent";
    const double place = servo.position();
    for (int i = 0; i < 20'000; ++i) {
        servo.step(100e-6, kStep);
    }
    EXPECT_EQ(servo.position(), place) << "no limit cycle";
}

TEST(Servo, BrakeHoldsWithoutPower) {
    Servo servo(ServoOptions{}, 0.25);
    for (int i = 0; i < 100; ++i) {
        servo.step(1.0, kStep);
    }
    EXPECT_EQ(servo.position(), 0.25);
}

TEST(Servo, EncoderReadsOnItsGridFromItsZero) {
    Servo servo(ServoOptions{}, 0.0123456);
    EXPECT_EQ(servo.counts(), 0);
    servo.set_counts_at(0.0123456, 500);
    EXPECT_EQ(servo.counts(), 500);
    EXPECT_NEAR(servo.place_of(-500), 0.0123456 - 1e-3, 1e-15);
}

TEST(Servo, FrozenEncoderStandsWhileTheAxisRunsAway) {
    Servo servo(ServoOptions{}, 0.0);
    servo.power(true);
    servo.freeze_encoder(true);
    for (int i = 0; i < 2000; ++i) {
        servo.step(100e-6, kStep);
    }
    EXPECT_EQ(servo.counts(), 0);
    EXPECT_GT(servo.position(), 1e-3);
    EXPECT_LE(servo.velocity(), ServoOptions{}.speed_limit);
}

TEST(Servo, ObstacleGivesWayByATenth) {
    Servo servo(frictionless(), 0.0);
    servo.power(true);
    servo.block(true);
    for (int i = 0; i < 4000; ++i) {
        servo.step(200e-6, kStep);
    }
    EXPECT_NEAR(servo.position(), 20e-6, 1e-6);
    servo.block(false);
    for (int i = 0; i < 4000; ++i) {
        servo.step(200e-6, kStep);
    }
    EXPECT_NEAR(servo.position(), 200e-6, 1e-6);
}

TEST(Trajectory, FollowsAParabolaExactlyAtTheTargets) {
    // Three targets behind it, the demand passes through each next one and has the parabola's speed there.
    Trajectory demand(0.0);
    const auto parabola = [](double t) { return 0.5 * 3.0 * t * t; };
    const double period = 2e-3;
    for (int k = 1; k <= 50; ++k) {
        demand.follow(parabola(k * period), period);
        for (int i = 0; i < 40; ++i) {
            demand.advance(period / 40);
        }
        ASSERT_NEAR(demand.position(), parabola(k * period), 1e-12);
        if (k > 3) {
            ASSERT_NEAR(demand.velocity(), 3.0 * k * period, 1e-9);
        }
    }
}

TEST(Trajectory, StaysAtTheLastTargetWhenSyncsAreMissing) {
    Trajectory demand(0.0);
    demand.follow(1e-3, 2e-3);
    for (int i = 0; i < 100; ++i) {
        demand.advance(kStep);
    }
    EXPECT_EQ(demand.position(), 1e-3);
    EXPECT_EQ(demand.velocity(), 0.0);
}

TEST(Trajectory, RampsDownWithItsDeceleration) {
    Trajectory demand(0.0);
    for (int k = 1; k <= 10; ++k) {
        demand.follow(k * 200e-6, 2e-3);
        for (int i = 0; i < 40; ++i) {
            demand.advance(kStep);
        }
    }
    const double from = demand.position();
    const double speed = demand.velocity();
    ASSERT_NEAR(speed, 0.1, 1e-6);
    demand.ramp_down(5.0);
    int steps = 0;
    while (!demand.at_rest() && steps < 10'000) {
        demand.advance(kStep);
        ++steps;
    }
    EXPECT_NEAR(demand.position() - from, speed * speed / (2.0 * 5.0), 5e-6);
    EXPECT_NEAR(steps * kStep, speed / 5.0, 2.0 * kStep);
}

TEST(Trajectory, SearchEndsExactlyOnTheGoalAtCreepSpeed) {
    for (const double start : {-0.3, -0.001, 0.0, 0.002, 0.4}) {
        Trajectory demand(start);
        demand.go_to(0.0, 0.1, 0.01, 5.0);
        double last_speed = 0.0;
        double fastest = 0.0;
        int steps = 0;
        while (!demand.at_rest() && steps < 1'000'000) {
            last_speed = std::abs(demand.velocity());
            fastest = std::max(fastest, last_speed);
            demand.advance(kStep);
            ++steps;
        }
        EXPECT_EQ(demand.position(), 0.0);
        EXPECT_LE(last_speed, 0.0101);
        EXPECT_LE(fastest, 0.1);
    }
}

}  // namespace
}  // namespace sc::sim
