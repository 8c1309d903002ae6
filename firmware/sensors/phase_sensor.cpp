// SPDX-License-Identifier: Apache-2.0
#include "firmware/sensors/phase_sensor.hpp"

#include "firmware/sensors/modbus_rtu.hpp"

namespace sc::sensors {
namespace {

constexpr std::uint16_t kContinuous = 0x0001;  ///< two registers, high word first
constexpr std::uint16_t kOffset = 0x0002;
constexpr std::uint16_t kLaser = 0x0003;
constexpr std::uint16_t kSingle = 0x000F;  ///< measures, and answers when it has

constexpr std::uint32_t kFaultBit = 0x8000'0000U;
constexpr std::uint32_t kUnits = 10'000;      ///< 0.1 mm in 10 nm
constexpr std::uint32_t kFarthest = 210'000;  ///< of 0.1 mm: what 32 bits of 10 nm can hold
constexpr std::int64_t kSinglePatienceNs = 1'500'000'000;

}  // namespace

bool PhaseSensor::compose(std::int64_t now_ns, Telegram& telegram) noexcept {
    if ((step_ == Step::measure || step_ == Step::dark) && due(now_ns)) {
        step_ = Step::identify;
    } else if (step_ == Step::measure && single_) {
        step_ = Step::laser_off;
    } else if (step_ == Step::dark) {
        step_ = Step::laser_on;
    }
    switch (step_) {
        case Step::identify:
            telegram = modbus::read(config_.address, modbus::kReadHolding, kOffset, 1, config_.patience_ns);
            break;
        case Step::dark:
        case Step::laser_on: telegram = modbus::write_many(config_.address, kLaser, 1, config_.patience_ns); break;
        case Step::laser_off: telegram = modbus::write_many(config_.address, kLaser, 0, config_.patience_ns); break;
        case Step::measure:
            telegram = modbus::read(config_.address, modbus::kReadHolding, kContinuous, 2, config_.patience_ns);
            break;
        case Step::fire:
            telegram = modbus::read(config_.address, modbus::kReadHolding, kSingle, 2, kSinglePatienceNs);
            break;
    }
    telegram.step = static_cast<std::uint8_t>(step_);
    return step_ == Step::measure;
}

void PhaseSensor::understand(const Reply& reply, std::int64_t now_ns) noexcept {
    switch (static_cast<Step>(reply.step)) {
        case Step::identify: {
            const bool right = config_.identity == 0 || config_.identity == modbus::register_of(reply.view(), 0);
            identified(right, now_ns);
            step_ = !right ? Step::identify : (single_ ? Step::laser_off : Step::laser_on);
            break;
        }
        case Step::laser_on:
            lit(now_ns);
            step_ = single_ ? Step::fire : Step::measure;
            break;
        case Step::laser_off:
            reading_.touch();
            step_ = single_ ? Step::dark : Step::laser_on;
            lit_ = false;
            break;
        case Step::measure:
            if (warm(now_ns)) {
                take_value(reply);
            } else {
                reading_.touch();
            }
            break;
        case Step::fire:
            take_value(reply);
            step_ = Step::laser_off;
            break;
        case Step::dark: break;
    }
}

void PhaseSensor::take_value(const Reply& reply) noexcept {
    const std::uint32_t raw =
        std::uint32_t{modbus::register_of(reply.view(), 0)} << 16U | modbus::register_of(reply.view(), 1);
    if ((raw & kFaultBit) != 0) {
        reading_.take_own_fault(static_cast<std::uint8_t>(raw & 0xFFU));
    } else if (raw > kFarthest) {
        reading_.take_nothing(reply.asked_ns);
    } else {
        reading_.take(static_cast<SensorValue>(raw * kUnits), reply.asked_ns);
    }
}

}  // namespace sc::sensors
