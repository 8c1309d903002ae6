// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/drive_configuration.hpp"

#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include <gtest/gtest.h>

namespace sc::drives {
namespace {

/// Position in the list of the n-th write of an object.
std::optional<std::size_t> place_of(const DriveSetup& setup, std::uint16_t index, std::uint8_t sub, int n = 0) {
    for (std::size_t i = 0; i < setup.size(); ++i) {
        if (setup[i].key.index == index && setup[i].key.sub == sub && n-- == 0) {
            return i;
        }
    }
    return std::nullopt;
}

TEST(DriveSetup, HasItsSteps) {
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const DriveSetup setup(reference_machine(), axis);
        EXPECT_GT(setup.size(), 30U);
        EXPECT_EQ(setup.size(), 37U);
    }
}

TEST(DriveSetup, MapsEachPdoWhileItIsOffAndEmpty) {
    const DriveSetup setup(reference_machine(), 2);
    for (const std::uint16_t communication : {std::uint16_t{0x1400}, std::uint16_t{0x1800}}) {
        const auto mapping = static_cast<std::uint16_t>(communication + 0x200);
        const auto off = place_of(setup, communication, 1, 0).value();
        const auto emptied = place_of(setup, mapping, 0, 0).value();
        const auto first = place_of(setup, mapping, 1).value();
        const auto second = place_of(setup, mapping, 2).value();
        const auto counted = place_of(setup, mapping, 0, 1).value();
        const auto on = place_of(setup, communication, 1, 1).value();
        EXPECT_TRUE(off < emptied && emptied < first && first < second && second < counted && counted < on);
        EXPECT_NE(setup[off].value & 0x8000'0000U, 0U);
        EXPECT_EQ(setup[emptied].value, 0U);
        EXPECT_EQ(setup[counted].value, 2U);
        EXPECT_EQ(setup[on].value & 0x8000'0000U, 0U);
        EXPECT_EQ(setup[off].value & 0x7FFU, setup[on].value & 0x7FFU);
        EXPECT_EQ(setup[place_of(setup, communication, 2).value()].value, 1U);
    }
    EXPECT_EQ(setup[place_of(setup, 0x1400, 1, 1).value()].value, 0x203U);
    EXPECT_EQ(setup[place_of(setup, 0x1800, 1, 1).value()].value & 0x7FFU, 0x183U);
}

TEST(DriveSetup, WritesThePeriodOfTheSync) {
    MachineConfig machine = reference_machine();
    machine.drive_cycle_ticks = 4;
    const DriveSetup setup(machine, 0);
    EXPECT_EQ(setup[place_of(setup, 0x60C2, 1).value()].value, 4U);
    EXPECT_EQ(setup[place_of(setup, 0x60C2, 2).value()].value, 0xFDU);
    EXPECT_EQ(setup[place_of(setup, 0x60C2, 1).value()].kind, SetupStep::Kind::write_checked);
    EXPECT_EQ(setup[place_of(setup, 0x1006, 0).value()].value, 4000U);
}

TEST(DriveSetup, ConvertsTheAxisIntoCounts) {
    MachineConfig machine = reference_machine();
    machine.axis[0].home_position = -0.0015;
    const DriveSetup x(machine, 0);
    EXPECT_EQ(x[place_of(x, 0x607C, 0).value()].value, static_cast<std::uint32_t>(-1500));
    EXPECT_EQ(x[place_of(x, 0x6085, 0).value()].value, 5'000'000U);
    // 0.2 mm window and 0.2 m/s for 4 ms.
    EXPECT_EQ(x[place_of(x, 0x6065, 0).value()].value, 1000U);
    const DriveSetup c(machine, 3);
    EXPECT_EQ(c[place_of(c, 0x6099, 1).value()].value, 22'500U);
    EXPECT_EQ(c[place_of(c, 0x609A, 0).value()].value, 180'000U);
}

TEST(DriveSetup, WatchesTheMaster) {
    const DriveSetup setup(reference_machine(), 0);
    EXPECT_EQ(setup[place_of(setup, 0x1016, 1).value()].value, (127U << 16U) | 100U);
    EXPECT_EQ(setup[place_of(setup, 0x1017, 0).value()].value, 20U);
}

TEST(RoundToI32, HalvesGoAwayFromZero) {
    EXPECT_EQ(round_to_i32(0.5), 1);
    EXPECT_EQ(round_to_i32(-0.5), -1);
    EXPECT_EQ(round_to_i32(2.5), 3);
    EXPECT_EQ(round_to_i32(-2.5), -3);
    EXPECT_EQ(round_to_i32(0.49999999999999994), 0);
    EXPECT_EQ(round_to_i32(-0.49999999999999994), 0);
}

TEST(RoundToI32, ClampsAndTakesNoNan) {
    EXPECT_EQ(round_to_i32(2147483647.0), INT32_MAX);
    EXPECT_EQ(round_to_i32(2147483646.5), INT32_MAX);
    EXPECT_EQ(round_to_i32(1e300), INT32_MAX);
    EXPECT_EQ(round_to_i32(-2147483648.0), INT32_MIN);
    EXPECT_EQ(round_to_i32(-1e300), INT32_MIN);
    EXPECT_EQ(round_to_i32(std::numeric_limits<double>::quiet_NaN()), 0);
    EXPECT_EQ(round_to_u32(-1.0), 0U);
    EXPECT_EQ(round_to_u32(4294967294.6), UINT32_MAX);
    EXPECT_EQ(round_to_u32(1e300), UINT32_MAX);
    EXPECT_EQ(round_to_u32(std::numeric_limits<double>::quiet_NaN()), 0U);
}

TEST(RoundToI32, AgreesWithTheLibrary) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> value(-2.1e9, 2.1e9);
    for (int i = 0; i < 100'000; ++i) {
        const double v = i % 2 == 0 ? value(random) : std::floor(value(random)) + 0.5;
        ASSERT_EQ(round_to_i32(v), std::lround(v)) << v;
    }
}

}  // namespace
}  // namespace sc::drives
