// SPDX-License-Identifier: Apache-2.0
#include "shared/machine/axis_map.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "shared/hash/crc.hpp"
#include "shared/link/map_codec.hpp"
#include "tests/unit/firmware/motion/sample_map.hpp"

namespace sc {
namespace {

const MachineConfig kMachine = reference_machine();

MapFinding checked(const AxisMap& map) {
    MapCost cost;
    return check_map(kMachine, map, cost);
}

TEST(AxisMap, TheIdentityIsGoodAndCostsNothing) {
    MapCost cost;
    EXPECT_EQ(check_map(kMachine, {}, cost).refusal, Refusal::none);
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        EXPECT_EQ(cost.shift[i] + cost.speed[i] + cost.acceleration[i] + cost.jerk[i], 0.0);
    }
}

TEST(AxisMap, AMapOfTensOfMicrometresIsGoodAndCostsLessThanItsShare) {
    MapCost cost;
    ASSERT_EQ(check_map(kMachine, test::sample_map(), cost).refusal, Refusal::none);
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        EXPECT_GT(cost.jerk[i], 0.0);
        EXPECT_LE(cost.speed[i], kMapSpeedShare * kMachine.axis[i].speed);
        EXPECT_LE(cost.acceleration[i], kMapAccelerationShare * kMachine.axis[i].acceleration);
        EXPECT_LE(cost.jerk[i], kMapJerkShare * kMachine.axis[i].jerk);
    }
}

TEST(AxisMap, ASpikeIsRefusedWithItsAxisTableAndNode) {
    AxisMap map = test::sample_map();
    map.linear = {};
    map.linear[1][2][20] = 110'000'000;  // y along Z
    map.linear[1][2][21] = -110'000'000;
    const MapFinding finding = checked(map);
    EXPECT_EQ(finding.refusal, Refusal::map_too_steep);
    EXPECT_EQ(finding.axis, 1);
    EXPECT_EQ(finding.along, 2);
    EXPECT_NEAR(finding.node, 20, 3);
    const MapFinding again = MapFinding::from_detail(finding.refusal, finding.detail());
    EXPECT_EQ(again.axis, finding.axis);
    EXPECT_EQ(again.along, finding.along);
    EXPECT_EQ(again.node, finding.node);
}

TEST(AxisMap, ATakeUpThatIsTooQuickIsRefused) {
    AxisMap map;
    map.backlash[0] = 20'000'000;
    map.take_up[0] = 0.010;
    const MapFinding finding = checked(map);
    EXPECT_EQ(finding.refusal, Refusal::map_too_steep);
    EXPECT_EQ(finding.along, MapFinding::kBacklash);
    map.take_up[0] = 0.035;
    EXPECT_EQ(checked(map).refusal, Refusal::none);
    map.take_up[0] = 0.0;
    EXPECT_EQ(checked(map).refusal, Refusal::bad_map);
    map.take_up[0] = 0.035;
    map.backlash[0] = -1;
    EXPECT_EQ(checked(map).refusal, Refusal::bad_map);
}

TEST(AxisMap, ATableThatEndsWithinTheTravelIsRefused) {
    AxisMap map = test::sample_map();
    map.first[2] += 0.050;
    EXPECT_EQ(checked(map).refusal, Refusal::bad_map);
    EXPECT_EQ(checked(map).axis, 2);
}

TEST(AxisMap, NumbersThatAreNoneAndLargeCorrectionsAreRefused) {
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1.0}) {
        AxisMap map = test::sample_map();
        map.spacing[0] = bad;
        EXPECT_EQ(checked(map).refusal, Refusal::bad_map) << bad;
    }
    AxisMap map;
    map.turn[static_cast<std::size_t>(TurnTable::shift_z)].fill(400'000'000);
    EXPECT_EQ(checked(map).refusal, Refusal::bad_map);
    EXPECT_EQ(checked(map).axis, 2);
    map = {};
    map.turn[0].fill(150'000'000);
    EXPECT_EQ(checked(map).refusal, Refusal::bad_map);
    EXPECT_EQ(checked(map).axis, 3);
}

TEST(MapCodec, GivesBackEveryField) {
    const AxisMap map = test::sample_map();
    link::MapBytes bytes{};
    link::serialise(map, bytes);
    AxisMap read;
    EXPECT_TRUE(link::deserialise_map(bytes, read));
    EXPECT_EQ(read, map);
    EXPECT_EQ(link::map_crc(map), crc32(bytes));
    EXPECT_FALSE(link::deserialise_map(std::span(bytes).first(bytes.size() - 1), read));
    ++bytes[0];
    EXPECT_FALSE(link::deserialise_map(bytes, read)) << "another version";
    EXPECT_EQ(link::map_crc({}), 0U);
    EXPECT_NE(link::map_crc(map), 0U);
}

}  // namespace
}  // namespace sc
