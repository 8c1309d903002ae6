// SPDX-License-Identifier: Apache-2.0
#include "firmware/sensors/sensor_hub.hpp"

namespace sc::sensors {

SensorHub::SensorHub(const SensorsConfig& config, std::int64_t period_ns) noexcept
    : config_(config),
      buses_{Bus{BusMaster(config.bus[0], period_ns)}, Bus{BusMaster(config.bus[1], period_ns)}},
      period_ns_(period_ns) {
    for (std::size_t i = 0; i < kSensorCount; ++i) {
        const SensorConfig& one = config.sensor[i];
        switch (one.kind) {
            case SensorKind::none: break;
            case SensorKind::triangulation: sensors_[i].emplace<TriangulationSensor>(one); break;
            case SensorKind::phase: sensors_[i].emplace<PhaseSensor>(one); break;
            case SensorKind::ascii: sensors_[i].emplace<AsciiSensor>(one); break;
        }
    }
}

DistanceSensor* SensorHub::sensor(std::size_t i) noexcept {
    if (auto* triangulation = std::get_if<TriangulationSensor>(&sensors_[i])) {
        return triangulation;
    }
    if (auto* phase = std::get_if<PhaseSensor>(&sensors_[i])) {
        return phase;
    }
    return std::get_if<AsciiSensor>(&sensors_[i]);
}

Sample SensorHub::sample(std::size_t i) const noexcept {
    if (const auto* triangulation = std::get_if<TriangulationSensor>(&sensors_[i])) {
        return triangulation->sample(now_ns_);
    }
    if (const auto* phase = std::get_if<PhaseSensor>(&sensors_[i])) {
        return phase->sample(now_ns_);
    }
    const auto* ascii = std::get_if<AsciiSensor>(&sensors_[i]);
    return ascii != nullptr ? ascii->sample(now_ns_) : Sample{};
}

void SensorHub::fire_in_turn(bool on) noexcept {
    for (Slot& slot : sensors_) {
        if (auto* phase = std::get_if<PhaseSensor>(&slot)) {
            phase->fire_in_turn(on);
        }
    }
}

void SensorHub::step(const ServoInputs& in, ServoOutputs& out) noexcept {
    now_ns_ = in.tick * period_ns_;
    for (std::size_t b = 0; b < kSensorBuses; ++b) {
        out.sensor_tx[b].size = 0;
        if (config_.bus[b].baud == 0) {
            continue;
        }
        Bus& bus = buses_[b];
        Reply reply;
        if (bus.master.step(now_ns_, in.sensor_rx[b], reply)) {
            if (reply.tag == kLatchTag) {
                bus.latched_ns = reply.asked_ns;
            } else if (DistanceSensor* const whose = sensor(reply.tag)) {
                if (config_.bus[b].latch != 0) {
                    reply.asked_ns = bus.latched_ns;
                }
                whose->take(reply, now_ns_);
            }
        }
        if (bus.master.can_send(now_ns_)) {
            ask(b, out.sensor_tx[b]);
        }
    }
}

void SensorHub::ask(std::size_t b, SensorTransmission& out) noexcept {
    Bus& bus = buses_[b];
    Telegram telegram;
    for (std::size_t tried = 0; tried <= kSensorCount; ++tried) {
        if (bus.cursor == kSensorCount) {
            bus.cursor = 0;
            if (config_.bus[b].latch != 0) {
                telegram = TriangulationSensor::latch(2 * bus.master.timing().gap);
                telegram.tag = kLatchTag;
                bus.master.send(now_ns_, telegram, out);
                return;
            }
        }
        DistanceSensor* const one = sensor(bus.cursor);
        if (one == nullptr || one->config().bus != b) {
            ++bus.cursor;
            continue;
        }
        if (bus.held && !one->in_turn()) {
            bus.held = false;
            ++bus.cursor;
            continue;
        }
        const bool asks = one->next(now_ns_, telegram);
        bus.held = one->in_turn();
        telegram.tag = bus.cursor;
        bus.cursor = static_cast<std::uint8_t>(bus.cursor + (bus.held ? 0U : 1U));
        if (asks) {
            bus.master.send(now_ns_, telegram, out);
        }
        if (asks || bus.held) {
            return;
        }
    }
}

}  // namespace sc::sensors
