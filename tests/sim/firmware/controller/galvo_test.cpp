// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "cell_rig.hpp"
#include "undisturbed.hpp"

namespace sc::test {
namespace {

/// Enabled and homed, not armed.
void make_idle(CellRig& rig) {
    rig.connect();
    ASSERT_TRUE(rig.until_state(State::disabled, 5000));
    ASSERT_EQ(rig.command(link::Verb::enable).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::idle, 5000));
    ASSERT_EQ(rig.command(link::Verb::home).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::homing, 100));
    ASSERT_TRUE(rig.until_state(State::idle, 120'000));
}

TEST(Controller, RefusesToArmUntilTheGalvosConventionIsSet) {
    CellRig::Options options;
    options.machine.galvo.convention = GalvoConvention::unset;
    CellRig rig(options);
    make_idle(rig);
    EXPECT_EQ(static_cast<Refusal>(rig.command(link::Verb::arm).refusal), Refusal::galvo_convention_unset);
    EXPECT_EQ(rig.state(), State::idle);
}

TEST(Controller, MasterOscillatorComesOnOnlyThroughAProvenHeadAndAfterItsWarning) {
    CellRig rig;
    make_idle(rig);
    ASSERT_EQ(rig.command(link::Verb::arm).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::arming, 10));
    int warned = 0;
    while (!rig.cell().latest().digital.master_oscillator) {
        EXPECT_TRUE(rig.cell().latest().digital.light_yellow) << "emission warning";
        ASSERT_LT(++warned, 1000);
        rig.ticks(1);
    }
    EXPECT_EQ(warned, 500);
    ASSERT_TRUE(rig.until_state(State::armed, 20));
    EXPECT_EQ(rig.pulses().size(), 0U);
}

TEST(Controller, NoHeadMeansNoArming) {
    // A converter that says "all well" for ever has no head; a line that floats is not even well.
    for (const auto& [what, fault] :
         {std::pair{"absent", Fault::galvo_absent}, std::pair{"float_high", Fault::galvo_not_ready},
          std::pair{"float_low", Fault::galvo_not_ready}}) {
        CellRig::Options options;
        options.script = std::string("at 0.1 galvo ") + what + "\n";
        CellRig rig(options);
        make_idle(rig);
        ASSERT_EQ(rig.command(link::Verb::arm).refusal, 0);
        bool lit = false;
        ASSERT_TRUE(rig.until(
            [&] {
                lit = lit || rig.cell().latest().digital.master_oscillator;
                return rig.state() == State::fault;
            },
            1000))
            << what;
        rig.ticks(50);
        EXPECT_EQ(rig.status().first_fault, static_cast<std::uint8_t>(fault)) << what;
        EXPECT_FALSE(lit) << what;
    }
}

/// A correction that shifts every place by so much, without lens or lean.
GalvoField shifted_field(double x, double z) {
    GalvoField field;
    field.half = 0.060;
    const double cell = 2.0 * field.half / static_cast<double>(GalvoField::kCells);
    for (std::size_t i = 0; i < GalvoField::kNodes; ++i) {
        field.node[2 * i] = -field.half + cell * (static_cast<double>(i % GalvoField::kSide) - 1.0) + x;
        field.node[2 * i + 1] = -field.half + cell * (static_cast<double>(i / GalvoField::kSide) - 1.0) + z;
    }
    return field;
}

std::uint16_t send_field(CellRig& rig, const GalvoField& field) {
    link::SetGalvoField message;
    for (std::size_t first = 0; first < GalvoField::kNumbers; first += message.count) {
        message.first = static_cast<std::uint16_t>(first);
        message.count = static_cast<std::uint8_t>(std::min(message.numbers.size(), GalvoField::kNumbers - first));
        for (std::size_t i = 0; i < message.count; ++i) {
            message.numbers[i] = field.number(first + i);
        }
        const auto reply = rig.set_galvo_field(message);
        if (reply.refusal != 0) {
            return reply.refusal;
        }
    }
    message.first = GalvoField::kNumbers;
    message.count = 0;
    return rig.set_galvo_field(message).refusal;
}

TEST(Controller, AppliesTheGalvoFieldAndNothingElseOfTheJobChanges) {
    CellRig rig;
    rig.connect();
    ASSERT_EQ(send_field(rig, shifted_field(20e-6, -30e-6)), 0);
    make_idle(rig);
    ASSERT_EQ(rig.command(link::Verb::arm).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::armed, 1000));
    ASSERT_EQ(rig.open_job(short_job()).refusal, 0);
    ASSERT_EQ(rig.command(link::Verb::start).refusal, 0);
    ASSERT_TRUE(rig.until([&] { return (rig.status().flags & link::kFlagJobDone) != 0; }));
    EXPECT_EQ(rig.command_hash(), undisturbed().command_hash()) << "commands are places, not words";
    ASSERT_EQ(rig.pulses().size(), undisturbed().pulses().size());
    for (std::size_t i = 0; i < rig.pulses().size(); ++i) {
        const auto& with = rig.pulses()[i].place_pm;
        const auto& without = undisturbed().pulses()[i].place_pm;
        ASSERT_NEAR(static_cast<double>(with[0] - without[0]), 20e6, 2.5e6) << i;
        ASSERT_NEAR(static_cast<double>(with[2] - without[2]), -30e6, 2.5e6) << i;
    }
}

/// A lens' distortion and lean, about as large as a real one's.
GalvoField lens_field() {
    GalvoField field = shifted_field(20e-6, -30e-6);
    for (std::size_t i = 0; i < GalvoField::kNodes; ++i) {
        double& x = field.node[2 * i];
        double& z = field.node[2 * i + 1];
        const double square = x * x + z * z;
        x *= 1.0 + 4.0 * square;
        z *= 1.0 - 3.0 * square;
    }
    field.slope = {6.0, 0.0, 0.0, 5.5};
    field.bend = 3.0;
    return field;
}

TEST(Controller, SendsTheWordsOfEachFramesPlaceAndDepth) {
    constexpr double kDepthPerX = 0.1;
    const auto point = [](double x_mm, double z_mm) {
        const auto wire = [](double mm) { return static_cast<std::int32_t>(std::lround(mm * 1e5)); };
        return PathPoint{wire(-250.0 + x_mm), wire(-319.0 + kDepthPerX * x_mm), wire(-390.0 + z_mm)};
    };
    PathBegin begin;
    begin.actuator = Actuator::galvo;
    begin.speed_um_s = 2'000'000;
    begin.pitch_nm = 50'000;
    begin.energy_nj = 300'000;
    begin.tolerance_nm = 10'000;
    begin.anchor_x = point(0.0, 0.0).x;
    begin.anchor_y = point(0.0, 0.0).y;
    begin.anchor_z = point(0.0, 0.0).z;
    const std::vector<Item> items{
        Turn{0},   begin,   point(-50.0, -50.0), point(-20.0, 45.0), point(40.0, 44.0), point(50, -50.0),
        PathEnd{}, JobEnd{}};
    CellRig::Options options;
    options.machine.galvo.word = GalvoWord::bits18;
    options.machine.galvo.natural_frequency = {};  // what frames lead by is another matter
    CellRig rig(options);
    rig.connect();
    ASSERT_EQ(send_field(rig, lens_field()), 0);
    make_idle(rig);
    ASSERT_EQ(rig.command(link::Verb::arm).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::armed, 1000));
    ASSERT_EQ(rig.open_job(items).refusal, 0);
    ASSERT_EQ(rig.command(link::Verb::start).refusal, 0);
    laser::FieldMap map(options.machine.galvo);
    map.set(lens_field());
    const auto position = [](std::uint32_t word) { return static_cast<int>((word >> 1U) & 0x3FFFFU); };
    int frames = 0;
    int most = 0;
    double largest = 0.0;
    ASSERT_TRUE(rig.until([&] {
        for (const GalvoFrame& frame : rig.cell().latest().galvo) {
            const double x = static_cast<double>(frame.x_pm) * 1e-12;
            const double z = static_cast<double>(frame.z_pm) * 1e-12;
            const auto words = map.patch(x, z, kDepthPerX * x).words({x, z, kDepthPerX * x});
            most = std::max({most, std::abs(position(words[0]) - position(frame.word_x)),
                             std::abs(position(words[1]) - position(frame.word_z))});
            frames += rig.state() == State::marking ? 1 : 0;
            largest = std::max({largest, std::abs(x), std::abs(z)});
        }
        return (rig.status().flags & link::kFlagJobDone) != 0;
    }));
    EXPECT_GT(frames, 10'000);
    EXPECT_GT(largest, 0.050);
    EXPECT_LE(most, 1) << "a word is 0.47 um";
}

TEST(Controller, RefusesAGalvoFieldThatIsNoneOrComesOutOfOrder) {
    CellRig rig;
    rig.connect();
    ASSERT_TRUE(rig.until_state(State::disabled, 5000));
    const auto bad = static_cast<std::uint16_t>(Refusal::bad_config);
    GalvoField mirrored = shifted_field(0.0, 0.0);
    for (std::size_t i = 0; i < GalvoField::kNodes; ++i) {
        mirrored.node[2 * i] = -mirrored.node[2 * i];
    }
    EXPECT_EQ(send_field(rig, mirrored), bad);
    link::SetGalvoField message;
    message.count = 24;
    EXPECT_EQ(rig.set_galvo_field(message).refusal, 0);
    message.first = 48;
    EXPECT_EQ(rig.set_galvo_field(message).refusal, bad) << "a gap";
    message = {};
    message.first = 24;
    EXPECT_EQ(rig.set_galvo_field(message).refusal, bad) << "ended too early";
    message = {};
    message.count = 25;
    EXPECT_EQ(rig.set_galvo_field(message).refusal, bad) << "more than fit";
    EXPECT_EQ(rig.set_galvo_field({}).refusal, 0) << "taking it away";
    EXPECT_EQ(send_field(rig, shifted_field(0.0, 0.0)), 0);
}

TEST(Controller, TakesALagOfTheGalvoWithinItsRangeAndSaysWhatIsOutOfIt) {
    CellRig rig;
    rig.connect();
    ASSERT_TRUE(rig.until_state(State::disabled, 5000));
    const auto frequency = [](double hz) { return Frequency::from_si(hz); };
    EXPECT_EQ(rig.set_galvo_lag({173'800, frequency(1600.0), 0.75}).refusal, 0);
    EXPECT_EQ(rig.set_galvo_lag({}).refusal, 0) << "back to what the machine states";
    const auto bad = static_cast<std::uint16_t>(Refusal::bad_galvo_lag);
    const auto refused = [&](const GalvoLag& lag, std::int64_t detail) {
        const auto reply = rig.set_galvo_lag(lag);
        EXPECT_EQ(reply.refusal, bad);
        EXPECT_EQ(reply.detail, detail);
    };
    refused({400'000, frequency(2000.0), 0.75}, 1);
    refused({160'000, frequency(5000.0), 0.75}, 2);
    refused({160'000, frequency(2000.0), 0.01}, 3);
    refused({160'000, frequency(1600.0), 0.9}, 4);
}

TEST(Controller, RefusesALagOfTheGalvoWhileArmed) {
    CellRig rig;
    rig.make_ready();
    EXPECT_EQ(rig.set_galvo_lag({}).refusal, static_cast<std::uint16_t>(Refusal::wrong_state));
}

TEST(Controller, RefusesAGalvoFieldWhileArmed) {
    CellRig rig;
    rig.make_ready();
    EXPECT_EQ(rig.set_galvo_field({}).refusal, static_cast<std::uint16_t>(Refusal::wrong_state));
}

}  // namespace
}  // namespace sc::test
