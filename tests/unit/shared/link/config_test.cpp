// SPDX-License-Identifier: Apache-2.0
#include "shared/link/config.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace {

using sc::GalvoWord;
using sc::MachineConfig;
using sc::Refusal;
using sc::link::check;
using sc::link::deserialise;
using sc::link::kConfigSize;

std::array<std::uint8_t, kConfigSize> bytes_of(const MachineConfig& machine) {
    std::array<std::uint8_t, kConfigSize> bytes{};
    sc::link::serialise(machine, bytes);
    return bytes;
}

TEST(Config, TheReferenceMachineComesBack) {
    MachineConfig machine = sc::reference_machine();
    machine.keep_out_count = 2;
    machine.galvo.word = GalvoWord::bits18;
    machine.keep_out[1] = {{-0.1, -0.2, -0.3}, {0.1, 0.2, 0.3}};
    const auto back = deserialise(bytes_of(machine));
    ASSERT_TRUE(back.has_value());
    EXPECT_EQ(bytes_of(*back), bytes_of(machine));
    EXPECT_EQ(back->control_period_ns, machine.control_period_ns);
    EXPECT_EQ(back->axis[2].jerk, machine.axis[2].jerk);
    EXPECT_EQ(back->axis[3].drive_node, machine.axis[3].drive_node);
    EXPECT_EQ(back->galvo.convention, machine.galvo.convention);
    EXPECT_EQ(back->galvo.word, GalvoWord::bits18);
    EXPECT_EQ(back->laser.warning_ns, machine.laser.warning_ns);
    EXPECT_EQ(back->laser.prr_nominal, machine.laser.prr_nominal);
    EXPECT_EQ(back->y_retracted, machine.y_retracted);
    EXPECT_EQ(back->keep_out, machine.keep_out);
    EXPECT_EQ(back->held_link_timeout_ns, machine.held_link_timeout_ns);
}

TEST(Config, BeginsWithItsVersionAndTheControlPeriod) {
    const auto bytes = bytes_of(sc::reference_machine());
    EXPECT_EQ(bytes[0], sc::link::kConfigVersion);
    EXPECT_EQ(bytes[1], 0);
    // 1 000 000 = 0x0F4240
    EXPECT_EQ(bytes[2], 0x40);
    EXPECT_EQ(bytes[3], 0x42);
    EXPECT_EQ(bytes[4], 0x0F);
}

TEST(Config, RefusesAnotherVersionAndEveryOtherSize) {
    auto bytes = bytes_of(sc::reference_machine());
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        EXPECT_EQ(deserialise(std::span(bytes).first(size)).error(), Refusal::bad_config) << size;
    }
    std::vector<std::uint8_t> longer(bytes.begin(), bytes.end());
    longer.push_back(0);
    EXPECT_EQ(deserialise(longer).error(), Refusal::bad_config);
    bytes[1] = 1;
    EXPECT_EQ(deserialise(bytes).error(), Refusal::version_mismatch);
}

struct Bad {
    const char* what;
    std::function<void(MachineConfig&)> spoil;
};

const std::vector<Bad>& bad_configs() {
    using sc::Length;
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInf = std::numeric_limits<double>::infinity();
    static const std::vector<Bad> kBad{
        {"control period 0", [](MachineConfig& m) { m.control_period_ns = 0; }},
        {"galvo period does not divide", [](MachineConfig& m) { m.galvo_period_ns = 30'000 + 1; }},
        {"guard period negative", [](MachineConfig& m) { m.guard_period_ns = -1; }},
        {"drive cycle 0", [](MachineConfig& m) { m.drive_cycle_ticks = 0; }},
        {"travel NaN", [](MachineConfig& m) { m.axis[0].travel_min = kNan; }},
        {"travel infinite", [](MachineConfig& m) { m.axis[0].travel_max = kInf; }},
        {"travel empty", [](MachineConfig& m) { m.axis[1].travel_max = m.axis[1].travel_min; }},
        {"travel beyond wire units", [](MachineConfig& m) { m.axis[2].travel_min = -22.0; }},
        {"C beyond wire units", [](MachineConfig& m) { m.axis[3].travel_max = 21'475.0; }},
        {"speed 0", [](MachineConfig& m) { m.axis[0].speed = 0.0; }},
        {"acceleration negative", [](MachineConfig& m) { m.axis[0].acceleration = -1.0; }},
        {"jerk NaN", [](MachineConfig& m) { m.axis[3].jerk = kNan; }},
        {"counts 0", [](MachineConfig& m) { m.axis[0].counts_per_unit = 0.0; }},
        {"following window 0", [](MachineConfig& m) { m.axis[0].following_window = 0.0; }},
        {"home outside travel", [](MachineConfig& m) { m.axis[0].home_position = 1.0; }},
        {"latency negative", [](MachineConfig& m) { m.axis[0].latency_ns = -1; }},
        {"node 0", [](MachineConfig& m) { m.axis[0].drive_node = 0; }},
        {"node 128", [](MachineConfig& m) { m.axis[0].drive_node = 128; }},
        {"node twice", [](MachineConfig& m) { m.axis[3].drive_node = m.axis[0].drive_node; }},
        {"field negative", [](MachineConfig& m) { m.galvo.half_field = Length::from_si(-0.01); }},
        {"galvo counts infinite", [](MachineConfig& m) { m.galvo.counts_per_metre = kInf; }},
        {"galvo speed 0", [](MachineConfig& m) { m.galvo.speed = {}; }},
        {"galvo frequency negative",
         [](MachineConfig& m) { m.galvo.natural_frequency = sc::Frequency::from_si(-1.0); }},
        {"galvo frequency NaN", [](MachineConfig& m) { m.galvo.natural_frequency = sc::Frequency::from_si(kNan); }},
        {"galvo damping 0", [](MachineConfig& m) { m.galvo.damping = 0.0; }},
        {"galvo damping NaN", [](MachineConfig& m) { m.galvo.damping = kNan; }},
        {"galvo servo slower than its latency", [](MachineConfig& m) { m.galvo.latency_ns = 119'000; }},
        {"mirrors follow encoders that are not there",
         [](MachineConfig& m) { m.galvo.follow = sc::FollowAxes::encoders; }},
        {"encoder's counts negative", [](MachineConfig& m) { m.axis[0].encoder_counts_per_unit = -1.0; }},
        {"table's place NaN", [](MachineConfig& m) { m.table_y = Length::from_si(kNan); }},
        {"laser power 0", [](MachineConfig& m) { m.laser.power = {}; }},
        {"pulse rates crossed", [](MachineConfig& m) { m.laser.prr_min = 2.0 * m.laser.prr_nominal; }},
        {"guide speed 0", [](MachineConfig& m) { m.laser.guide_speed_max = {}; }},
        {"latch setup negative", [](MachineConfig& m) { m.laser.latch_setup_ns = -1; }},
        {"latch too wide", [](MachineConfig& m) { m.laser.latch_width_ns = 20'001; }},
        {"shutter time 0", [](MachineConfig& m) { m.laser.shutter_time_ns = 0; }},
        {"mo wait negative", [](MachineConfig& m) { m.laser.mo_wait_ns = -1; }},
        {"retracted outside travel", [](MachineConfig& m) { m.y_retracted = Length::from_si(0.1); }},
        {"park tolerance 0", [](MachineConfig& m) { m.park_tolerance = {}; }},
        {"too many keep-outs", [](MachineConfig& m) { m.keep_out_count = 9; }},
        {"keep-out inside out", [](MachineConfig& m) { std::swap(m.keep_out[0].min, m.keep_out[0].max); }},
        {"keep-out NaN", [](MachineConfig& m) { m.keep_out[0].max.z = kNan; }},
        {"heartbeat too short", [](MachineConfig& m) { m.heartbeat_timeout_ns = 19'999'999; }},
        {"heartbeat too long", [](MachineConfig& m) { m.heartbeat_timeout_ns = 500'000'001; }},
        {"held link negative", [](MachineConfig& m) { m.held_link_timeout_ns = -1; }},
    };
    return kBad;
}

TEST(Config, RefusesEveryParameterOutOfItsRange) {
    ASSERT_EQ(check(sc::reference_machine()), Refusal::none);
    for (const Bad& bad : bad_configs()) {
        MachineConfig machine = sc::reference_machine();
        bad.spoil(machine);
        EXPECT_EQ(check(machine), Refusal::bad_config) << bad.what;
        EXPECT_FALSE(deserialise(bytes_of(machine)).has_value()) << bad.what;
    }
}

TEST(Config, RefusesAnUnknownGalvoConvention) {
    MachineConfig machine = sc::reference_machine();
    machine.galvo.convention = static_cast<sc::GalvoConvention>(3);
    EXPECT_EQ(deserialise(bytes_of(machine)).error(), Refusal::bad_config);
}

TEST(Config, TheLasersSourceComesBackAndAnUnknownOneIsRefused) {
    MachineConfig machine = sc::reference_machine();
    machine.laser.source = sc::LaserSource::raycus;
    EXPECT_EQ(deserialise(bytes_of(machine))->laser.source, sc::LaserSource::raycus);
    machine.laser.source = static_cast<sc::LaserSource>(4);
    EXPECT_EQ(deserialise(bytes_of(machine)).error(), Refusal::bad_config);
}

TEST(Config, RefusesAnUnknownMeaningOfThePowerByte) {
    MachineConfig machine = sc::reference_machine();
    machine.laser.power_byte = static_cast<sc::PowerByte>(2);
    EXPECT_EQ(deserialise(bytes_of(machine)).error(), Refusal::bad_config);
}

TEST(Config, AGalvoWhoseServoIsUnknownIsSound) {
    MachineConfig machine = sc::reference_machine();
    machine.galvo.natural_frequency = {};
    machine.galvo.damping = 0.0;
    EXPECT_EQ(check(machine), Refusal::none);
    const sc::GalvoLead lead = sc::galvo_lead(machine.galvo, machine.galvo_period_ns);
    EXPECT_EQ(lead.per_velocity, 0.0);
    EXPECT_EQ(lead.per_acceleration, 0.0);
}

TEST(Config, AnUnusedKeepOutMayHoldAnything) {
    MachineConfig machine = sc::reference_machine();
    machine.keep_out[7].min.x = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(check(machine), Refusal::none);
}

}  // namespace
