// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "firmware/sensors/sensor_hub.hpp"
#include "tests/sim/firmware/sensors/sensor_rig.hpp"

namespace {

using namespace sc;
using sensors::Quality;
using sim::SensorTrouble;

constexpr double kMicrometre = 100.0;  // of 10 nm

TEST(SensorHub, EverySensorOfTheDefaultWorldGivesItsDistanceToWithinItsErrors) {
    SensorRig rig;
    rig.run(2.0);
    for (std::size_t i = 0; i < kSensorCount; ++i) {
        const auto sample = rig.sample(i);
        EXPECT_TRUE(sensors::usable(sample.quality)) << i << " code " << static_cast<int>(sample.code);
        // Zero, gain, cyclic error and 4 σ of noise.
        EXPECT_NEAR(sample.value, rig.truth(i), (i == kYSensor ? 40.0 : 800.0) * kMicrometre) << i;
        EXPECT_EQ(sample.bad, 0U) << i;
    }
}

TEST(SensorHub, AgeIsAsOldAsTheMeasurement) {
    sim::WorldSpec spec = plate_world();
    spec.sensors.y.dropouts = spec.sensors.triple.dropouts = 0.0;
    SensorRig rig(spec);
    rig.run(2.0);
    for (int i = 0; i < 500; ++i) {
        rig.tick();
        EXPECT_LE(rig.now_ns() - rig.sample(kYSensor).measured_ns, 20'000'000);
        // A value of 0.1 mm may come out the same twice.
        EXPECT_LE(rig.now_ns() - rig.sample(2).measured_ns, 130'000'000);
    }
}

TEST(SensorHub, ReadsBetweenTwoMeasurementsAreRepeats) {
    SensorRig rig;
    rig.run(4.0);
    const auto sample = rig.sample(1);
    // 20 measurements and some 66 reads a second.
    EXPECT_NEAR(sample.count, 80, 8);
    EXPECT_GT(sample.repeats, 120U);
}

struct Case {
    SensorTrouble trouble;
    Quality quality;
    SensorCode code;
};
void PrintTo(const Case& c, std::ostream* out) { *out << "code " << static_cast<int>(c.code); }

class SensorFaults : public testing::TestWithParam<std::tuple<Case, std::size_t>> {};

TEST_P(SensorFaults, EndInTheirOwnCodeAndNeverInAWrongValue) {
    const auto [fault, sensor] = GetParam();
    SensorRig rig;
    rig.run(2.0);
    ASSERT_TRUE(sensors::usable(rig.sample(sensor).quality));
    rig.plant().trouble(sensor, fault.trouble);
    // A device is asked who it is every five seconds.
    for (int i = 0; i < 6000; ++i) {
        rig.tick();
        const auto sample = rig.sample(sensor);
        if (sensors::usable(sample.quality)) {
            ASSERT_NEAR(sample.value, rig.truth(sensor), (sensor == kYSensor ? 50.0 : 900.0) * kMicrometre);
        }
    }
    EXPECT_EQ(rig.sample(sensor).quality, fault.quality);
    EXPECT_EQ(static_cast<int>(rig.sample(sensor).code), static_cast<int>(fault.code));
    // The others do not suffer.
    for (std::size_t other = 0; other < kSensorCount; ++other) {
        if (other != sensor) {
            EXPECT_TRUE(sensors::usable(rig.sample(other).quality)) << other;
        }
    }
    rig.plant().trouble(sensor, SensorTrouble::none);
    rig.run(1.5);
    EXPECT_TRUE(sensors::usable(rig.sample(sensor).quality)) << static_cast<int>(rig.sample(sensor).code);
}

INSTANTIATE_TEST_SUITE_P(
    All, SensorFaults,
    testing::Combine(testing::Values(Case{SensorTrouble::silent, Quality::faulty, SensorCode::timeout},
                                     Case{SensorTrouble::crc, Quality::faulty, SensorCode::bad_crc},
                                     Case{SensorTrouble::wrong_slave, Quality::faulty, SensorCode::wrong_slave},
                                     Case{SensorTrouble::exception, Quality::faulty, SensorCode::exception},
                                     Case{SensorTrouble::chopped, Quality::faulty, SensorCode::bad_frame},
                                     Case{SensorTrouble::stale, Quality::stale, SensorCode::frozen},
                                     Case{SensorTrouble::foreign, Quality::faulty, SensorCode::wrong_device}),
                     testing::Values(std::size_t{0}, std::size_t{2})));

TEST(SensorHub, NoLightIsOutOfRangeForTheYSensorAndTheOwnFaultOfAPhaseSensor) {
    SensorRig rig;
    rig.run(1.0);
    rig.plant().trouble(kYSensor, SensorTrouble::blind);
    rig.plant().trouble(3, SensorTrouble::blind);
    rig.run(0.5);
    EXPECT_EQ(rig.sample(kYSensor).quality, Quality::out_of_range);
    EXPECT_EQ(rig.sample(kYSensor).code, SensorCode::out_of_range);
    EXPECT_EQ(rig.sample(3).quality, Quality::faulty);
    EXPECT_EQ(rig.sample(3).code, SensorCode::own_fault);
    EXPECT_EQ(rig.sample(3).detail, 15);
}

TEST(SensorHub, ASlippedCycleIsFarFromTheValueAndOutOfRangeOrConfirmedButNeverNearIt) {
    SensorRig rig;
    rig.run(1.0);
    const double before = rig.sample(2).value;
    rig.plant().trouble(2, SensorTrouble::slipped);
    rig.run(1.0);
    const auto sample = rig.sample(2);
    // 150 mm: what a check of the seat refuses by far.
    EXPECT_NEAR(sample.value - before, 150e5, 900 * kMicrometre);
}

TEST(SensorHub, LasersInTurnAreNeverOnTogether) {
    SensorRig rig;
    rig.run(1.0);
    rig.hub().fire_in_turn(true);
    rig.run(1.0);
    const std::uint32_t before = rig.sample(1).count + rig.sample(2).count + rig.sample(3).count;
    int most = 0;
    for (int i = 0; i < 4000; ++i) {
        rig.tick();
        int lit = 0;
        for (std::size_t s = 1; s <= 3; ++s) {
            lit += dynamic_cast<sim::PhaseDevice&>(*rig.plant().device(s)).laser() ? 1 : 0;
        }
        most = std::max(most, lit);
    }
    EXPECT_EQ(most, 1);
    EXPECT_GE(rig.sample(1).count + rig.sample(2).count + rig.sample(3).count, before + 15);
    rig.hub().fire_in_turn(false);
    rig.run(1.0);
    for (std::size_t s = 1; s <= 3; ++s) {
        EXPECT_TRUE(dynamic_cast<sim::PhaseDevice&>(*rig.plant().device(s)).laser());
        EXPECT_TRUE(sensors::usable(rig.sample(s).quality));
    }
}

TEST(SensorHub, ABroadcastLatchStampsTheInstant) {
    SensorsConfig config = reference_machine().sensors;
    config.bus[0].latch = 1;
    SensorRig rig(plate_world(), config);
    rig.run(2.0);
    EXPECT_TRUE(sensors::usable(rig.sample(kYSensor).quality));
    EXPECT_NEAR(rig.sample(kYSensor).value, rig.truth(kYSensor), 40 * kMicrometre);
}

TEST(SensorHub, ASensorOfLinesOfTextFitsUnderTheSameInterface) {
    SensorsConfig config = reference_machine().sensors;
    config.sensor[kYSensor].kind = SensorKind::ascii;
    SensorRig rig(plate_world(), config);
    rig.run(1.0);
    EXPECT_NEAR(rig.sample(kYSensor).value, rig.truth(kYSensor), 40 * kMicrometre);
    EXPECT_TRUE(sensors::usable(rig.sample(kYSensor).quality));
    const std::map<SensorTrouble, SensorCode> codes{
        {SensorTrouble::silent, SensorCode::timeout},          {SensorTrouble::crc, SensorCode::bad_crc},
        {SensorTrouble::wrong_slave, SensorCode::wrong_slave}, {SensorTrouble::exception, SensorCode::own_fault},
        {SensorTrouble::blind, SensorCode::out_of_range},      {SensorTrouble::stale, SensorCode::frozen}};
    for (const auto& [trouble, code] : codes) {
        rig.plant().trouble(kYSensor, trouble);
        rig.run(2.0);
        EXPECT_EQ(static_cast<int>(rig.sample(kYSensor).code), static_cast<int>(code));
        rig.plant().trouble(kYSensor, SensorTrouble::none);
        rig.run(1.0);
        EXPECT_TRUE(sensors::usable(rig.sample(kYSensor).quality));
    }
}

}  // namespace
