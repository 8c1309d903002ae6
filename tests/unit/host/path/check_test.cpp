// SPDX-License-Identifier: Apache-2.0
#include "host/path/check.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace sc::host {
namespace {

constexpr KeepOut kBox{{-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}};

TEST(KeepOutMeets, SeesAWayThroughAndAWayWithin) {
    EXPECT_TRUE(meets(kBox, {-1.0, 0.0, 0.0}, {1.0, 0.0, 0.0}));
    EXPECT_TRUE(meets(kBox, {0.01, 0.0, 0.0}, {0.02, 0.03, 0.0}));
    EXPECT_TRUE(meets(kBox, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}));
}

TEST(KeepOutMeets, TouchingCounts) {
    EXPECT_TRUE(meets(kBox, {0.1, -1.0, 0.0}, {0.1, 1.0, 0.0}));
    EXPECT_TRUE(meets(kBox, {0.2, 0.0, 0.0}, {0.1, 0.0, 0.0}));
}

TEST(KeepOutMeets, MissesAWayThatEndsBeforeOrGoesPastACorner) {
    EXPECT_FALSE(meets(kBox, {0.3, 0.0, 0.0}, {0.101, 0.0, 0.0}));
    EXPECT_FALSE(meets(kBox, {0.0, 0.25, 0.0}, {0.25, 0.0, 0.0}));
    EXPECT_FALSE(meets(kBox, {0.2, -1.0, 0.0}, {0.2, 1.0, 0.0}));
}

TEST(LimitsAlong, AreThoseOfTheSlowestAxisThatMoves) {
    MachineConfig machine = reference_machine();
    machine.axis[index(Axis::z)].speed = 0.05;
    EXPECT_NEAR(limits_along({1.0, 0.0, 0.0}, Actuator::axes, machine).speed, 0.2, 1e-12);
    EXPECT_NEAR(limits_along({0.0, 0.0, 1.0}, Actuator::axes, machine).speed, 0.05, 1e-12);
    const double slant = std::sqrt(0.5);
    EXPECT_NEAR(limits_along({slant, 0.0, slant}, Actuator::axes, machine).speed, 0.05 / slant, 1e-12);
}

TEST(LimitsAlong, MirrorsDoNotMoveInDepth) {
    const MachineConfig machine = reference_machine();
    const double slant = std::sqrt(0.5);
    EXPECT_NEAR(limits_along({slant, slant, 0.0}, Actuator::galvo, machine).speed, 2.0 / slant, 1e-12);
}

TEST(RunIn, IsLongerThanTheSpeedNeedsAndGrowsWithIt) {
    const MachineConfig machine = reference_machine();
    double last = 0.0;
    for (const double speed : {0.002, 0.02, 0.05, 0.1, 0.2}) {
        const MarkSettings settings{
            .actuator = Actuator::axes, .speed = Speed::from_si(speed), .pitch = {}, .energy = {}};
        const double length = run_in_length({1.0, 0.0, 0.0}, settings, machine);
        EXPECT_GT(length, speed * speed / (2.0 * 5.0));
        EXPECT_GT(length, speed_up_distance(speed, {0.2, 5.0, 200.0}) + 0.4e-3);
        EXPECT_GT(length, last);
        last = length;
    }
}

}  // namespace
}  // namespace sc::host
