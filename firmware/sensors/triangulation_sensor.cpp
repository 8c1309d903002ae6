// SPDX-License-Identifier: Apache-2.0
#include "firmware/sensors/triangulation_sensor.hpp"

#include "firmware/sensors/modbus_rtu.hpp"

namespace sc::sensors {
namespace {

// Input registers: 1 type, 2 firmware, 3 serial number, 4 base (mm), 5 range (mm), 6 value.
constexpr std::uint16_t kFirstIdentity = 1;
constexpr std::uint8_t kIdentityRegisters = 5;
constexpr std::size_t kSerial = 2;
constexpr std::size_t kBase = 3;
constexpr std::size_t kRange = 4;
constexpr std::uint16_t kValue = 6;
// Holding registers.
constexpr std::uint16_t kLaserOn = 10;
constexpr std::uint16_t kLatch = 41;

constexpr std::uint16_t kFull = 16384;
constexpr std::int64_t kUnitsPerMillimetre = 100'000;
constexpr std::uint32_t kFarthestMm = 21'000;  ///< what 32 bits of 10 nm can hold

}  // namespace

Telegram TriangulationSensor::latch(std::int64_t patience_ns) noexcept {
    return modbus::write(modbus::kBroadcast, kLatch, 1, patience_ns);
}

bool TriangulationSensor::compose(std::int64_t now_ns, Telegram& telegram) noexcept {
    if (step_ == Step::measure && due(now_ns)) {
        step_ = Step::identify;
    }
    switch (step_) {
        case Step::identify:
            telegram = modbus::read(config_.address, modbus::kReadInput, kFirstIdentity, kIdentityRegisters,
                                    config_.patience_ns);
            break;
        case Step::laser_on: telegram = modbus::write(config_.address, kLaserOn, 1, config_.patience_ns); break;
        case Step::measure:
            telegram = modbus::read(config_.address, modbus::kReadInput, kValue, 1, config_.patience_ns);
            break;
    }
    telegram.step = static_cast<std::uint8_t>(step_);
    return step_ == Step::measure;
}

void TriangulationSensor::understand(const Reply& reply, std::int64_t now_ns) noexcept {
    switch (static_cast<Step>(reply.step)) {
        case Step::identify: {
            const std::uint16_t serial = modbus::register_of(reply.view(), kSerial);
            base_mm_ = modbus::register_of(reply.view(), kBase);
            range_mm_ = modbus::register_of(reply.view(), kRange);
            const bool measures = range_mm_ > 0 && std::uint32_t{base_mm_} + range_mm_ <= kFarthestMm;
            const bool right = measures && (config_.identity == 0 || config_.identity == serial);
            identified(right, now_ns);
            step_ = right ? Step::laser_on : Step::identify;
            break;
        }
        case Step::laser_on:
            lit(now_ns);
            step_ = Step::measure;
            break;
        case Step::measure: {
            if (!warm(now_ns)) {
                reading_.touch();
                break;
            }
            const std::uint16_t d = modbus::register_of(reply.view(), 0);
            if (d == 0 || d > kFull) {
                reading_.take_nothing(reply.asked_ns);
            } else {
                const std::int64_t depth = std::int64_t{d} * range_mm_ * kUnitsPerMillimetre / kFull;
                reading_.take(static_cast<SensorValue>(base_mm_ * kUnitsPerMillimetre + depth), reply.asked_ns);
            }
            break;
        }
    }
}

}  // namespace sc::sensors
