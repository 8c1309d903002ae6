// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/serial_wire.hpp"

#include <algorithm>

namespace sc::sim {
namespace {

/// Ten bits, in units of baud · ns.
constexpr std::int64_t kByteCost = 10 * 1'000'000'000LL;

}  // namespace

SerialWire::SerialWire(std::uint32_t baud, std::int64_t tick_ns, std::size_t most_per_tick)
    : earned_per_tick_(static_cast<std::int64_t>(baud) * tick_ns), most_per_tick_(most_per_tick) {}

void SerialWire::push(std::span<const std::uint8_t> bytes) {
    if (connected_) {
        queue_.insert(queue_.end(), bytes.begin(), bytes.end());
    }
}

void SerialWire::tick(std::vector<std::uint8_t>& out) {
    earned_ += earned_per_tick_;
    const auto affordable = static_cast<std::size_t>(earned_ / kByteCost);
    const std::size_t count = std::min({affordable, queue_.size(), most_per_tick_});
    out.insert(out.end(), queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(count));
    queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(count));
    earned_ -= static_cast<std::int64_t>(count) * kByteCost;
    // Only the begun byte carries over.
    earned_ = std::min(earned_, kByteCost - 1);
    if (queue_.empty()) {
        earned_ = 0;
    }
}

void SerialWire::set_connected(bool connected) {
    connected_ = connected;
    if (!connected_) {
        queue_.clear();
    }
}

}  // namespace sc::sim
