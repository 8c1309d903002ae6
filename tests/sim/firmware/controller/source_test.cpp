// SPDX-License-Identifier: Apache-2.0
// What the source is told and makes of it: power by its measured curve, pulse width over its serial port.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "cell_rig.hpp"
#include "undisturbed.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;

constexpr double kBend = -0.4;
constexpr double kAsked = 300'000.0;  // nJ
constexpr std::string_view kIdealLaser =
    "[laser]\npower_time_constant_us = 0.0\nfirst_pulse_excess = 0.0\npower_bend = ";

/// The reference cell with an ideal laser but for a bent power curve.
fs::path bent_world(double bend) {
    const fs::path file = fs::path(testing::TempDir()) / ("bent" + std::to_string(bend) + ".toml");
    std::ofstream(file) << "version = 1\nbase = \"" SC_SOURCE_DIR "/boards/sim/world/default/world.toml\"\n"
                        << kIdealLaser << bend << "\n";
    return file;
}

/// What a power meter would show of it, at 17 bytes.
PowerCurve measured(double bend) {
    PowerCurve curve;
    curve.count = PowerCurve::kPoints;
    for (std::size_t i = 0; i < curve.count; ++i) {
        curve.byte[i] = static_cast<std::uint8_t>(i == 16 ? 255 : 16 * i);
        const double share = curve.byte[i] / 255.0;
        curve.watts[i] = 80.0 * share * (1.0 + bend * (1.0 - share));
    }
    return curve;
}

struct Energies {
    double mean = 0.0;
    double worst = 0.0;  ///< largest relative error
};
Energies burn(CellRig& rig) {
    EXPECT_EQ(rig.command(link::Verb::arm).refusal, 0);
    EXPECT_TRUE(rig.until_state(State::armed, 1000));
    EXPECT_EQ(rig.open_job(short_job()).refusal, 0);
    EXPECT_EQ(rig.command(link::Verb::start).refusal, 0);
    EXPECT_TRUE(rig.until([&] { return (rig.status().flags & link::kFlagJobDone) != 0; }, 60'000));
    EXPECT_EQ(rig.pulses().size(), undisturbed().pulses().size());
    EXPECT_EQ(rig.cell().plant().laser_counters().wrong_power, 0U);
    Energies e;
    for (const trace::PulseRecord& pulse : rig.pulses()) {
        e.mean += pulse.energy_nj / static_cast<double>(rig.pulses().size());
        e.worst = std::max(e.worst, std::abs(pulse.energy_nj / kAsked - 1.0));
    }
    return e;
}

void make_idle(CellRig& rig) {
    rig.connect();
    ASSERT_TRUE(rig.until_state(State::disabled, 5000));
    ASSERT_EQ(rig.command(link::Verb::enable).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::idle, 5000));
    ASSERT_EQ(rig.command(link::Verb::home).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::homing, 100));
    ASSERT_TRUE(rig.until_state(State::idle, 120'000));
}

CellRig::Options in_world(double bend) {
    CellRig::Options options;
    options.world = bent_world(bend);
    return options;
}

TEST(PowerCurve, WithItABentSourceGivesTheEnergyThatIsAskedFor) {
    CellRig rig(in_world(kBend));
    make_idle(rig);
    ASSERT_EQ(rig.set_power_curve(measured(kBend)).refusal, 0);
    const Energies e = burn(rig);
    // Half a step of the byte at the lowest rate, and the chord between two points.
    EXPECT_LT(e.worst, 0.02);
    EXPECT_NEAR(e.mean / kAsked, 1.0, 0.003);
}

TEST(PowerCurve, WithoutItTheEnergyIsOff) {
    CellRig rig(in_world(kBend));
    make_idle(rig);
    const Energies e = burn(rig);
    EXPECT_LT(e.mean / kAsked, 0.80) << "70 % of the power at a third of the byte";
    CellRig other(in_world(0.0));
    make_idle(other);
    ASSERT_EQ(other.set_power_curve(measured(kBend)).refusal, 0);
    EXPECT_GT(burn(other).mean / kAsked, 1.2) << "and another source's curve is as wrong";
}

TEST(PowerCurve, AStraightOneOfTwoPointsChangesNothing) {
    CellRig rig;
    make_idle(rig);
    PowerCurve straight;
    straight.count = 2;
    straight.byte[1] = 255;
    straight.watts[1] = 80.0;
    ASSERT_EQ(rig.set_power_curve(straight).refusal, 0);
    static_cast<void>(burn(rig));
    EXPECT_EQ(rig.command_hash(), undisturbed().command_hash());
}

TEST(PowerCurve, ABadOneIsRefusedWithItsPointAndTheOneInForceStays) {
    CellRig rig(in_world(kBend));
    make_idle(rig);
    ASSERT_EQ(rig.set_power_curve(measured(kBend)).refusal, 0);
    PowerCurve falls = measured(kBend);
    falls.watts[5] = falls.watts[4];
    PowerCurve one;
    one.count = 1;
    PowerCurve short_of_full = measured(kBend);
    short_of_full.count = 16;
    PowerCurve no_number = measured(kBend);
    no_number.watts[2] = std::nan("");
    for (const auto& [curve, point] :
         {std::pair{falls, 5}, std::pair{one, 0}, std::pair{short_of_full, 15}, std::pair{no_number, 2}}) {
        const auto reply = rig.set_power_curve(curve);
        EXPECT_EQ(static_cast<Refusal>(reply.refusal), Refusal::bad_power_curve);
        EXPECT_EQ(reply.detail, point);
    }
    EXPECT_LT(burn(rig).worst, 0.02);
    EXPECT_EQ(static_cast<Refusal>(rig.set_power_curve(measured(kBend)).refusal), Refusal::wrong_state) << "armed";
}

TEST(PowerCurve, AnEnergyThatItCannotGiveIsRefused) {
    CellRig rig;
    make_idle(rig);
    PowerCurve strong = measured(0.0);  // it gives no less than 20 W: 250 uJ at 80 kHz, twice that at 40
    strong.count = 2;
    strong.byte = {0, 255};
    strong.watts = {20.0, 80.0};
    ASSERT_EQ(rig.set_power_curve(strong).refusal, 0);
    ASSERT_EQ(rig.command(link::Verb::arm).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::armed, 1000));
    ASSERT_EQ(rig.open_job(short_job()).refusal, 0);
    ASSERT_EQ(rig.command(link::Verb::start).refusal, 0);
    ASSERT_TRUE(rig.until([&] { return rig.refused().has_value(); }, 20'000));
    EXPECT_EQ(rig.refused()->refusal, static_cast<std::uint16_t>(Refusal::bad_energy));
}

CellRig::Options of_maker(LaserSource source, const std::string& script = "") {
    CellRig::Options options;
    options.machine.laser.source = source;
    options.script = script;
    return options;
}

constexpr LaserSource kMopas[]{LaserSource::raycus, LaserSource::jpt};

TEST(PulseWidth, IsSetAndReadBackFromEitherMaker) {
    for (const LaserSource source : kMopas) {
        CellRig rig(of_maker(source));
        rig.connect();
        ASSERT_TRUE(rig.until_state(State::disabled, 5000));
        for (const int width : {20, 350, 2}) {
            const auto reply = rig.command(link::Verb::set_pulse_width, width);
            EXPECT_EQ(reply.refusal, 0) << width;
            EXPECT_EQ(reply.detail, width);
            EXPECT_EQ(rig.cell().plant().mopa().width_ns(), static_cast<unsigned>(width));
        }
    }
}

TEST(PulseWidth, WhatTheSourceRefusesOrAnswersOtherwiseIsRefused) {
    for (const LaserSource source : kMopas) {
        CellRig rig(of_maker(source, "at 2 laser stubborn\n"));
        rig.connect();
        ASSERT_TRUE(rig.until_state(State::disabled, 1500));
        for (const int width : {999, 1, 0, -5, 1000}) {
            const auto reply = rig.command(link::Verb::set_pulse_width, width);
            EXPECT_EQ(static_cast<Refusal>(reply.refusal), Refusal::pulse_width_refused) << width;
        }
        ASSERT_EQ(rig.command(link::Verb::set_pulse_width, 30).refusal, 0);
        rig.until([&] { return rig.cell().now_ns() > 2'100'000'000; });
        const auto reply = rig.command(link::Verb::set_pulse_width, 20);
        EXPECT_EQ(static_cast<Refusal>(reply.refusal), Refusal::pulse_width_refused);
        EXPECT_EQ(reply.detail, 30) << "what it says is in force";
    }
}

TEST(PulseWidth, ASilentSourceAndAForeignOneAreNoticed) {
    struct Case {
        LaserSource configured;
        const char* event;
        Refusal refusal;
    };
    for (const Case& c : {Case{LaserSource::raycus, "laser mute", Refusal::pulse_width_no_answer},
                          Case{LaserSource::jpt, "laser mute", Refusal::pulse_width_no_answer},
                          Case{LaserSource::raycus, "laser speaks_jpt", Refusal::pulse_width_wrong_source},
                          Case{LaserSource::jpt, "laser speaks_raycus", Refusal::pulse_width_no_answer}}) {
        CellRig rig(of_maker(c.configured, std::string("at 0.1 ") + c.event + "\n"));
        rig.connect();
        ASSERT_TRUE(rig.until_state(State::disabled, 5000));
        rig.until([&] { return rig.cell().now_ns() > 200'000'000; });
        const std::int64_t asked_ns = rig.cell().now_ns();
        EXPECT_EQ(static_cast<Refusal>(rig.command(link::Verb::set_pulse_width, 20).refusal), c.refusal) << c.event;
        EXPECT_LT(rig.cell().now_ns() - asked_ns, 200'000'000);
    }
}

TEST(PulseWidth, IsRefusedWhileTheLaserIsArmedAndByASourceWithoutAPort) {
    CellRig rig;
    rig.make_ready();
    EXPECT_EQ(static_cast<Refusal>(rig.command(link::Verb::set_pulse_width, 20).refusal),
              Refusal::pulse_width_while_armed);
    ASSERT_EQ(rig.command(link::Verb::disarm).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::idle, 1000));
    EXPECT_EQ(rig.command(link::Verb::set_pulse_width, 20).refusal, 0);
    for (const LaserSource source : {LaserSource::none, LaserSource::ipg}) {
        CellRig other(of_maker(source));
        other.connect();
        EXPECT_EQ(static_cast<Refusal>(other.command(link::Verb::set_pulse_width, 20).refusal),
                  Refusal::pulse_width_unsupported);
    }
}

}  // namespace
}  // namespace sc::test
