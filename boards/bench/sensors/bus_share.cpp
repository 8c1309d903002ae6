// SPDX-License-Identifier: Apache-2.0
#include "boards/bench/sensors/bus_share.hpp"

#include <memory>
#include <vector>

#include "boards/sim/sensors/sensor_plant.hpp"
#include "firmware/sensors/sensor_hub.hpp"

namespace sc::bench {
namespace {

constexpr std::int64_t kPeriodNs = 1'000'000;
constexpr std::int64_t kWarmUpTicks = 2000;
/// Of the simulated sensors (boards/sim/sensors/sensor_devices.cpp).
constexpr double kTriangulationTurnRound = 200e-6;
constexpr double kPhaseTurnRound = 400e-6;
/// A place before the default world's casting where the Y sensor sees it.
constexpr Vec3 kReading{-0.250, -0.330, -0.350};

struct Counts {
    double readings = 0.0;
    double fresh = 0.0;
};
Counts count(const sensors::SensorHub& hub, std::size_t first, std::size_t sensors) {
    Counts out;
    for (std::size_t i = first; i < first + sensors; ++i) {
        const auto sample = hub.sample(i);
        out.readings += static_cast<double>(sample.count) + sample.repeats;
        out.fresh += sample.count;
    }
    return out;
}

double silence_of(const SensorBusConfig& bus) {
    const double character = (bus.parity == SensorParity::none ? 10.0 : 11.0) / bus.baud;
    return bus.baud > 19'200 && bus.short_gaps == 0 ? 1.75e-3 : 3.5 * character;
}

/// What a line has carried since the last silence.
struct Line {
    std::vector<SensorByte> bytes;
};

/// Keeps what has come, and gives it out once the last byte is old enough.
void hold_back(Line& line, std::vector<SensorByte>& bytes, double silence) {
    for (SensorByte& byte : line.bytes) {
        byte.age_us = static_cast<std::uint16_t>(byte.age_us + kPeriodNs / 1000);
    }
    line.bytes.insert(line.bytes.end(), bytes.begin(), bytes.end());
    bytes.clear();
    if (!line.bytes.empty() && line.bytes.back().age_us * 1e-6 >= silence) {
        bytes.swap(line.bytes);
    }
}

BusShare share_of(const Counts& before, const Counts& after, double seconds, double limit) {
    return {(after.readings - before.readings) / seconds, (after.fresh - before.fresh) / seconds, limit};
}

}  // namespace

double readings_per_s(const SensorBusConfig& bus, int request_bytes, int answer_bytes, double turn_round_s) {
    const double character = (bus.parity == SensorParity::none ? 10.0 : 11.0) / bus.baud;
    const double silence = silence_of(bus);
    return 1.0 / ((request_bytes + answer_bytes) * character + 2.0 * silence + turn_round_s);
}

BusShares measure_bus_shares(const sim::World& world, const SensorsConfig& config, double seconds,
                             bool whole_telegrams) {
    sim::SensorPlant plant(config, world);
    sensors::SensorHub hub(config, kPeriodNs);
    const auto out = std::make_unique<ServoOutputs>();
    std::array<SensorTransmission, kSensorBuses> acting{};
    std::array<Line, kSensorBuses> lines;
    std::array<std::vector<SensorByte>, kSensorBuses> heard;
    Counts y_before;
    Counts triple_before;
    const auto end = kWarmUpTicks + static_cast<std::int64_t>(seconds * 1e3);
    for (std::int64_t tick = 0; tick < end; ++tick) {
        if (tick == kWarmUpTicks) {
            y_before = count(hub, kYSensor, 1);
            triple_before = count(hub, kFirstTriple, kTripleCount);
        }
        ServoInputs in;
        in.tick = tick;
        plant.take(tick * kPeriodNs, heard);
        for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
            if (whole_telegrams) {
                hold_back(lines.at(bus), heard.at(bus), silence_of(config.bus.at(bus)));
            }
            in.sensor_rx.at(bus) = heard.at(bus);
        }
        hub.step(in, *out);
        plant.transmit(tick * kPeriodNs, acting);
        acting = out->sensor_tx;
        plant.step_to((tick + 1) * kPeriodNs, kReading, 0.0);
    }
    const double y_limit = readings_per_s(config.bus[0], 8, 7, kTriangulationTurnRound);
    const double triple_limit = readings_per_s(config.bus[1], 8, 9, kPhaseTurnRound);
    return {share_of(y_before, count(hub, kYSensor, 1), seconds, y_limit),
            share_of(triple_before, count(hub, kFirstTriple, kTripleCount), seconds, triple_limit)};
}

}  // namespace sc::bench
