// SPDX-License-Identifier: Apache-2.0
// Whatever happens on the line, a value that is called usable is the truth. Chops, noise, flipped and lost bytes, late
// and doubled answers, at random.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "firmware/sensors/sensor_hub.hpp"
#include "tests/sim/firmware/sensors/sensor_rig.hpp"

namespace {

using namespace sc;

constexpr std::int64_t kPeriodNs = 1'000'000;

std::uint64_t seed() {
    const char* const given = std::getenv("SC_SEED");
    const std::uint64_t value = given != nullptr ? std::strtoull(given, nullptr, 10) : 20'260'101;
    std::cout << "seed " << value << " (SC_SEED=" << value << " to repeat)\n";
    return value;
}

/// A line between hub and sensors that spoils a share of what comes.
class BadLine {
public:
    explicit BadLine(std::uint64_t seed_value) : random_(seed_value) {}

    std::vector<SensorByte> spoil(const std::vector<SensorByte>& bytes) {
        std::vector<SensorByte> out;
        for (SensorByte byte : bytes) {
            const unsigned lot = below(100);
            if (lot < 2) {
                continue;  // lost
            }
            if (lot < 5) {
                byte.data = static_cast<std::uint8_t>(byte.data ^ (1U << below(8)));
            } else if (lot < 7) {
                byte.data = static_cast<std::uint8_t>(below(256));
            } else if (lot < 8) {
                byte.flags = 1;
            }
            out.push_back(byte);
            if (lot == 8) {
                out.push_back(byte);  // twice
            }
        }
        if (below(50) == 0 && out.size() < kSensorBytesPerTick) {
            out.push_back({static_cast<std::uint8_t>(below(256)), 0, static_cast<std::uint16_t>(below(10))});
        }
        if (below(200) == 0 && !bytes.empty()) {
            memory_ = bytes;
        }
        if (below(100) == 0) {
            // An answer of long ago.
            for (const SensorByte& byte : memory_) {
                if (out.size() < kSensorBytesPerTick) {
                    out.push_back(byte);
                }
            }
        }
        std::ranges::sort(out, std::ranges::greater{}, &SensorByte::age_us);
        return out;
    }

private:
    unsigned below(unsigned n) { return std::uniform_int_distribution<unsigned>(0, n - 1)(random_); }
    std::mt19937_64 random_;
    std::vector<SensorByte> memory_;
};

TEST(SensorNoiseOnTheLine, NeverGivesAWrongValue) {
    const sim::World world(plate_world(), plates());
    const SensorsConfig config = reference_machine().sensors;
    sim::SensorPlant plant(config, world);
    sensors::SensorHub hub(config, kPeriodNs);
    BadLine line(seed());
    const auto out = std::make_unique<ServoOutputs>();
    std::array<SensorTransmission, kSensorBuses> acting{};
    std::array<std::vector<SensorByte>, kSensorBuses> rx;
    const Vec3 reading{-0.2, -0.330, -0.3};
    std::array<double, kSensorCount> truth{};
    for (std::size_t i = 0; i < kSensorCount; ++i) {
        truth.at(i) = plant.target(i, reading, 0.0)->distance * 1e8;
    }
    std::uint64_t usable = 0;
    for (std::int64_t tick = 0; tick < 1'000'000; ++tick) {
        ServoInputs in;
        in.tick = tick;
        plant.take(tick * kPeriodNs, rx);
        for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
            rx.at(bus) = line.spoil(rx.at(bus));
            in.sensor_rx.at(bus) = rx.at(bus);
        }
        hub.step(in, *out);
        plant.transmit(tick * kPeriodNs, acting);
        acting = out->sensor_tx;
        plant.step_to((tick + 1) * kPeriodNs, reading, 0.0);
        for (std::size_t i = 0; i < kSensorCount; ++i) {
            const auto sample = hub.sample(i);
            if (sensors::usable(sample.quality)) {
                ++usable;
                ASSERT_NEAR(sample.value, truth.at(i), i == kYSensor ? 5'000.0 : 90'000.0)
                    << "sensor " << i << " tick " << tick;
            }
        }
    }
    // The noise is so bad that most answers fail, and yet values come through.
    EXPECT_GT(hub.sample(0).bad, 1'000U);
    EXPECT_GT(usable, 50'000U);
}

}  // namespace
