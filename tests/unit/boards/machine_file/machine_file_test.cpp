// SPDX-License-Identifier: Apache-2.0
#include "boards/machine_file/machine_file.hpp"

#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace sc::machine_file {
namespace {

std::string why(const std::string& text) {
    try {
        static_cast<void>(parse_machine(text, "m.toml"));
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "taken";
}

TEST(MachineFile, WhatIsNotNamedIsAsInTheReferenceCell) {
    const MachineConfig machine = parse_machine("", "m.toml");
    const MachineConfig reference = reference_machine();
    EXPECT_EQ(machine.axis[0].travel_min, reference.axis[0].travel_min);
    EXPECT_EQ(machine.keep_out_count, reference.keep_out_count);
    EXPECT_EQ(machine.laser.source, reference.laser.source);
}

TEST(MachineFile, NumbersComeInTheUnitsOfTheirNames) {
    const MachineConfig m = parse_machine(R"(
drive_cycle_ms = 4
keep_out_mm = [[[-460, -410, -510], [10, 10, -480.5]], [[0, 0, 0], [1, 1, 1]]]
[x]
node = 11
counts_per_mm = 10000
travel_min_mm = -300
speed_mm_s = 150.5
latency_us = 5000
[c]
counts_per_deg = 100
speed_deg_s = 20
[laser]
source = "ipg"
prr_nominal_khz = 60
warning_ms = 700
[sensors]
fitted = false
)",
                                          "m.toml");
    EXPECT_EQ(m.drive_cycle_ticks, 4U);
    EXPECT_EQ(m.axis[0].drive_node, 11);
    EXPECT_DOUBLE_EQ(m.axis[0].counts_per_unit, 1e7);
    EXPECT_DOUBLE_EQ(m.axis[0].travel_min, -0.3);
    EXPECT_DOUBLE_EQ(m.axis[0].speed, 0.1505);
    EXPECT_EQ(m.axis[0].latency_ns, 5'000'000);
    EXPECT_DOUBLE_EQ(m.axis[3].counts_per_unit, 100.0);
    EXPECT_DOUBLE_EQ(m.axis[3].speed, 20.0);
    EXPECT_EQ(m.laser.source, LaserSource::ipg);
    EXPECT_DOUBLE_EQ(m.laser.prr_nominal.si(), 60e3);
    EXPECT_EQ(m.laser.warning_ns, 700'000'000);
    EXPECT_EQ(m.keep_out_count, 2);
    EXPECT_DOUBLE_EQ(m.keep_out[0].max.z, -0.4805);
    for (const SensorConfig& sensor : m.sensors.sensor) {
        EXPECT_EQ(sensor.kind, SensorKind::none);
    }
}

TEST(MachineFile, RefusesWithFileLineAndKey) {
    EXPECT_NE(why("[x]\nnodes = 1\n").find("m.toml:2: x.nodes"), std::string::npos);
    EXPECT_NE(why("[x]\nspeed_mm_s = \"fast\"\n").find("m.toml:2: x.speed_mm_s"), std::string::npos);
    EXPECT_NE(why("\n[laser]\nsource = \"sun\"\n").find("m.toml:3: laser.source"), std::string::npos);
    EXPECT_NE(why("keep_out_mm = [[1, 2]]\n").find("m.toml:1: keep_out_mm"), std::string::npos);
    EXPECT_NE(why("keep_out_mm = 5\n").find("keep_out_mm"), std::string::npos);
    EXPECT_NE(why("[sensors]\nfitted = 1\n").find("m.toml:2: sensors.fitted"), std::string::npos);
    EXPECT_NE(why("[x\n").find("m.toml:1"), std::string::npos);
    EXPECT_NE(why("[x]\nspeed_mm_s = nan\n").find("x.speed_mm_s"), std::string::npos);
}

TEST(MachineFile, RefusesAMachineThatNoControllerCanRunWith) {
    for (const char* text : {"[x]\nspeed_mm_s = 0\n", "[x]\nnode = 2\n", "[x]\nnode = 500\n", "[x]\nhome_mm = 100\n",
                             "drive_cycle_ms = 0\n"}) {
        EXPECT_NE(why(text).find("no controller can run"), std::string::npos) << text << why(text);
    }
}

TEST(MachineFile, AFileThatIsNotThereIsNamed) {
    EXPECT_THROW(static_cast<void>(read_machine("/there/is/none.toml")), std::invalid_argument);
}

}  // namespace
}  // namespace sc::machine_file
