// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/sensors/rs485_line.hpp"

#include <algorithm>
#include <limits>

namespace sc::sim {
namespace {

constexpr std::uint8_t kFramingError = 2;

}  // namespace

Rs485Line::Rs485Line(const SensorBusConfig& bus)
    : character_ns_(bus.baud == 0 ? 1 : (bus.parity == SensorParity::none ? 10 : 11) * 1'000'000'000LL / bus.baud) {}

void Rs485Line::put(std::int64_t begin_ns, std::uint8_t data, std::size_t from) {
    Byte byte{begin_ns + character_ns_, data, from, false};
    for (Byte& other : on_line_) {
        if (other.from != from && other.end_ns > begin_ns && other.end_ns - character_ns_ < byte.end_ns) {
            other.garbled = byte.garbled = true;
            ++collisions_;
        }
    }
    const auto at = std::ranges::upper_bound(on_line_, byte.end_ns, {}, &Byte::end_ns);
    on_line_.insert(at, byte);
}

void Rs485Line::transmit(std::int64_t begin_ns, std::span<const std::uint8_t> bytes) {
    std::int64_t t = begin_ns;
    for (const std::uint8_t byte : bytes) {
        put(t, byte, kController);
        t += character_ns_;
    }
    deaf_from_ns_ = begin_ns;
    deaf_to_ns_ = t;
}

void Rs485Line::disturb(std::int64_t begin_ns, std::uint8_t byte) { put(begin_ns, byte, kNobody); }

void Rs485Line::deliver(const Byte& byte) {
    const bool deaf = byte.end_ns > deaf_from_ns_ && byte.end_ns - character_ns_ < deaf_to_ns_;
    if (byte.from != kController && !deaf) {
        const std::uint8_t flags = byte.garbled ? kFramingError : std::uint8_t{0};
        heard_.push_back({byte.end_ns, {byte.data, flags, 0}});
    }
    for (std::size_t i = 0; i < devices_.size(); ++i) {
        if (byte.from != i) {
            devices_[i]->hear(byte.data, byte.garbled, byte.end_ns);
        }
    }
}

void Rs485Line::run_to(std::int64_t t_ns) {
    while (true) {
        std::int64_t next = on_line_.empty() ? std::numeric_limits<std::int64_t>::max() : on_line_.front().end_ns;
        std::size_t actor = devices_.size();
        for (std::size_t i = 0; i < devices_.size(); ++i) {
            const auto due = devices_[i]->due_ns();
            if (due && *due < next) {
                next = *due;
                actor = i;
            }
        }
        if (next > t_ns) {
            return;
        }
        if (actor == devices_.size()) {
            const Byte byte = on_line_.front();
            on_line_.erase(on_line_.begin());
            deliver(byte);
        } else if (const auto answer = devices_[actor]->act(next)) {
            std::int64_t t = answer->begin_ns;
            for (std::size_t k = 0; k < answer->bytes.size(); ++k) {
                t += k > 0 && k == answer->pause_before ? answer->pause_ns : 0;
                put(t, answer->bytes[k], actor);
                t += character_ns_;
            }
        }
    }
}

void Rs485Line::take(std::int64_t t_ns, std::vector<SensorByte>& out) {
    for (Heard& heard : heard_) {
        heard.byte.age_us = static_cast<std::uint16_t>(std::min<std::int64_t>((t_ns - heard.end_ns) / 1000, 0xFFFF));
        if (out.size() < kSensorBytesPerTick) {
            out.push_back(heard.byte);
        } else {
            out.back().flags |= 4U;
        }
    }
    heard_.clear();
}

}  // namespace sc::sim
