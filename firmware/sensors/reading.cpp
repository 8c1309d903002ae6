// SPDX-License-Identifier: Apache-2.0
#include "firmware/sensors/reading.hpp"

namespace sc::sensors {

bool Reading::near_to(SensorValue a, SensorValue b) const noexcept {
    const std::int64_t apart = std::int64_t{a} - b;
    return apart <= config_.jump && -apart <= config_.jump;
}

/// A checksum of 16 bits lets one burst of 65 536 through, and a beam may catch a spark or an edge: a value far from
/// the last one counts only when the next measurement agrees with it.
bool Reading::believed(SensorValue value, std::int64_t asked_ns) noexcept {
    if (config_.jump == 0 || (sample_.count > 0 && near_to(value, sample_.value))) {
        candidate_ = false;
        return true;
    }
    const bool same_measurement = value == candidate_value_ && asked_ns - candidate_ns_ < config_.update_ns;
    if (candidate_ && same_measurement) {
        return false;
    }
    if (candidate_ && near_to(value, candidate_value_)) {
        candidate_ = false;
        return true;
    }
    candidate_ = true;
    candidate_value_ = value;
    candidate_ns_ = asked_ns;
    return false;
}

void Reading::take(SensorValue value, std::int64_t asked_ns) noexcept {
    if (value < config_.near || value > config_.far) {
        take_nothing(asked_ns);
        return;
    }
    failures_ = 0;
    const std::int64_t since = asked_ns - asked_ns_;
    asked_ns_ = asked_ns;
    if (!believed(value, asked_ns)) {
        return;
    }
    word_ = Word::value;
    const bool changed = sample_.count == 0 || value != sample_.value;
    repeated_ = !changed && asked_ns - fresh_ns_ < config_.update_ns;
    if (repeated_) {
        ++sample_.repeats;
        return;
    }
    if (changed) {
        changed_ns_ = asked_ns;
    }
    fresh_ns_ = asked_ns;
    sample_.value = value;
    // It became available between the last read and this one, at most one period ago.
    sample_.measured_ns = asked_ns - (since < config_.update_ns ? since : config_.update_ns) / 2;
    ++sample_.count;
}

void Reading::take_nothing(std::int64_t asked_ns) noexcept {
    failures_ = 0;
    asked_ns_ = asked_ns;
    candidate_ = false;
    word_ = Word::no_target;
}

void Reading::take_own_fault(std::uint8_t detail) noexcept {
    failures_ = 0;
    candidate_ = false;
    sample_.detail = detail;
    word_ = Word::own_fault;
}

void Reading::fail(SensorCode code, std::uint8_t detail) noexcept {
    ++sample_.bad;
    sample_.last_bad = code;
    sample_.detail = detail;
    if (failures_ < kFailures) {
        ++failures_;
    }
}

Sample Reading::at(std::int64_t now_ns) const noexcept {
    Sample out = sample_;
    const auto say = [&out](Quality quality, SensorCode code) noexcept {
        out.quality = quality;
        out.code = code;
        return out;
    };
    if (foreign_) {
        return say(Quality::faulty, SensorCode::wrong_device);
    }
    if (lost()) {
        return say(Quality::faulty, sample_.last_bad);
    }
    switch (word_) {
        case Word::nothing: return say(Quality::none, candidate_ ? SensorCode::unconfirmed : SensorCode::not_read);
        case Word::no_target: return say(Quality::out_of_range, SensorCode::out_of_range);
        case Word::own_fault: return say(Quality::faulty, SensorCode::own_fault);
        case Word::value: break;
    }
    if (config_.stuck_ns > 0 && asked_ns_ - changed_ns_ >= config_.stuck_ns) {
        return say(Quality::stale, SensorCode::frozen);
    }
    if (now_ns - sample_.measured_ns > config_.too_old_ns) {
        return say(Quality::stale, candidate_ ? SensorCode::unconfirmed : SensorCode::too_old);
    }
    out.detail = 0;
    return say(repeated_ ? Quality::repeated : Quality::good, SensorCode::none);
}

}  // namespace sc::sensors
