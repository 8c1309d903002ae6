// SPDX-License-Identifier: Apache-2.0
#include "firmware/sensors/distance_sensor.hpp"

namespace sc::sensors {

bool DistanceSensor::compose(std::int64_t /*now_ns*/, Telegram& telegram) noexcept {
    telegram = {};
    return true;
}

void DistanceSensor::understand(const Reply& reply, std::int64_t /*now_ns*/) noexcept {
    reading_.fail(SensorCode::bad_frame, reply.detail);
}

void DistanceSensor::restart() noexcept {}

bool DistanceSensor::next(std::int64_t now_ns, Telegram& telegram) noexcept {
    if (waits_ || now_ns < retry_at_) {
        return false;
    }
    waits_ = !compose(now_ns, telegram);
    return true;
}

void DistanceSensor::take(const Reply& reply, std::int64_t now_ns) noexcept {
    waits_ = false;
    if (reply.code == SensorCode::none) {
        understand(reply, now_ns);
        return;
    }
    reading_.fail(reply.code, reply.detail);
    if (reading_.lost()) {
        lit_ = false;
        restart();
        retry_at_ = now_ns + kRetryNs;
    }
}

/// It is lit again after each look at its identity, in case it was switched off and on meanwhile.
void DistanceSensor::lit(std::int64_t now_ns) noexcept {
    reading_.touch();
    if (!lit_) {
        lit_ = true;
        warm_at_ = now_ns + 3 * config_.update_ns;
    }
}

void DistanceSensor::identified(bool right, std::int64_t now_ns) noexcept {
    reading_.touch();
    reading_.identify(right);
    identify_at_ = now_ns + kIdentifyNs;
    if (!right) {
        retry_at_ = now_ns + kRetryNs;
    }
}

}  // namespace sc::sensors
