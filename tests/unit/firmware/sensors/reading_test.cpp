// SPDX-License-Identifier: Apache-2.0
#include "firmware/sensors/reading.hpp"

#include <gtest/gtest.h>

namespace {

using namespace sc;
using namespace sc::sensors;

constexpr std::int64_t kMs = 1'000'000;

SensorConfig config() {
    SensorConfig c;
    c.near = 1'000;
    c.far = 2'000;
    c.jump = 100;
    c.update_ns = 10 * kMs;
    c.stuck_ns = 200 * kMs;
    c.too_old_ns = 50 * kMs;
    return c;
}

TEST(Reading, BeginsWithNothing) {
    const Reading reading(config());
    EXPECT_EQ(reading.at(0).quality, Quality::none);
    EXPECT_EQ(reading.at(0).code, SensorCode::not_read);
}

TEST(Reading, TheFirstValueWaitsForASecond) {
    Reading reading(config());
    reading.take(1'500, 10 * kMs);
    EXPECT_EQ(reading.at(10 * kMs).code, SensorCode::unconfirmed);
    reading.take(1'503, 20 * kMs);
    EXPECT_EQ(reading.at(20 * kMs).quality, Quality::good);
    EXPECT_EQ(reading.at(20 * kMs).value, 1'503);
}

TEST(Reading, ASparkIsNeverShown) {
    Reading reading(config());
    for (int i = 1; i <= 5; ++i) {
        reading.take(1'500 + i, i * 10 * kMs);
    }
    reading.take(1'900, 60 * kMs);
    EXPECT_EQ(reading.at(60 * kMs).value, 1'505);
    EXPECT_EQ(reading.at(60 * kMs).quality, Quality::good);
    reading.take(1'506, 70 * kMs);
    EXPECT_EQ(reading.at(70 * kMs).value, 1'506);
    // Read twice, a spark is still one measurement.
    reading.take(1'900, 80 * kMs);
    reading.take(1'900, 84 * kMs);
    EXPECT_EQ(reading.at(84 * kMs).value, 1'506);
    // An edge stays.
    reading.take(1'902, 90 * kMs);
    EXPECT_EQ(reading.at(90 * kMs).value, 1'902);
}

TEST(Reading, TellsRepeatedFromNewFromFrozen) {
    SensorConfig c = config();
    c.jump = 0;
    Reading reading(c);
    reading.take(1'500, 10 * kMs);
    reading.take(1'500, 14 * kMs);
    EXPECT_EQ(reading.at(14 * kMs).quality, Quality::repeated);
    EXPECT_EQ(reading.at(14 * kMs).count, 1U);
    EXPECT_EQ(reading.at(14 * kMs).repeats, 1U);
    // The same again after the sensor's period is a new measurement.
    reading.take(1'500, 20 * kMs);
    EXPECT_EQ(reading.at(20 * kMs).quality, Quality::good);
    EXPECT_EQ(reading.at(20 * kMs).count, 2U);
    for (int i = 3; i <= 22; ++i) {
        reading.take(1'500, i * 10 * kMs);
    }
    EXPECT_EQ(reading.at(220 * kMs).quality, Quality::stale);
    EXPECT_EQ(reading.at(220 * kMs).code, SensorCode::frozen);
    reading.take(1'501, 230 * kMs);
    EXPECT_EQ(reading.at(230 * kMs).quality, Quality::good);
}

TEST(Reading, GrowsOldAndSaysSo) {
    SensorConfig c = config();
    c.jump = 0;
    Reading reading(c);
    reading.take(1'500, 10 * kMs);
    EXPECT_EQ(reading.at(50 * kMs).quality, Quality::good);
    EXPECT_EQ(reading.at(61 * kMs).quality, Quality::stale);
    EXPECT_EQ(reading.at(61 * kMs).code, SensorCode::too_old);
}

TEST(Reading, OutOfRangeIsNoFault) {
    SensorConfig c = config();
    c.jump = 0;
    Reading reading(c);
    reading.take(1'500, 10 * kMs);
    std::int64_t t = 10 * kMs;
    for (const SensorValue wrong : {999, 2'001}) {
        t += 10 * kMs;
        reading.take(wrong, t);
        EXPECT_EQ(reading.at(t).quality, Quality::out_of_range);
        EXPECT_EQ(reading.at(t).value, 1'500);
        t += 10 * kMs;
        reading.take(1'500, t);
        EXPECT_EQ(reading.at(t).quality, Quality::good);
    }
}

TEST(Reading, ThreeFailuresInARowMakeItFaultyAndOneAnswerMakesItWell) {
    SensorConfig c = config();
    c.jump = 0;
    Reading reading(c);
    reading.take(1'500, 10 * kMs);
    reading.fail(SensorCode::bad_crc, 0);
    reading.fail(SensorCode::timeout, 0);
    EXPECT_TRUE(usable(reading.at(20 * kMs).quality));
    reading.fail(SensorCode::exception, 2);
    EXPECT_EQ(reading.at(20 * kMs).quality, Quality::faulty);
    EXPECT_EQ(reading.at(20 * kMs).code, SensorCode::exception);
    EXPECT_EQ(reading.at(20 * kMs).detail, 2);
    EXPECT_EQ(reading.at(20 * kMs).bad, 3U);
    reading.take(1'501, 30 * kMs);
    EXPECT_EQ(reading.at(30 * kMs).quality, Quality::good);
}

TEST(Reading, AnotherDeviceIsFaultyWhateverItSays) {
    SensorConfig c = config();
    c.jump = 0;
    Reading reading(c);
    reading.take(1'500, 10 * kMs);
    reading.identify(false);
    EXPECT_EQ(reading.at(10 * kMs).code, SensorCode::wrong_device);
    reading.identify(true);
    EXPECT_EQ(reading.at(10 * kMs).quality, Quality::good);
}

}  // namespace
