// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/carrier/serial_line.hpp"

#include <algorithm>
#include <utility>

namespace sc::sim {

void SerialLine::send(std::size_t end, std::span<const std::uint8_t> bytes, std::int64_t now_ns) {
    Way& way = to_[1 - end];
    for (const std::uint8_t byte : bytes) {
        way.begun.push_back(byte);
        if (byte == 0) {
            put(way, std::exchange(way.begun, {}), now_ns);
        }
    }
}

void SerialLine::put(Way& way, std::vector<std::uint8_t> bytes, std::int64_t now_ns) {
    ++frames_;
    constexpr std::int64_t kBits = 10'000'000'000;
    const std::int64_t begin = std::max(way.free_ns, now_ns);
    way.free_ns = begin + static_cast<std::int64_t>(bytes.size()) * kBits / baud_;
    const TroubleRates& rates = troubles_.rates();
    const bool lost = troubles_.chance(rates.lose) || troubles_.chance(rates.destroy);
    if (lost || troubles_.cut(begin)) {
        return;
    }
    if (troubles_.chance(rates.spoil)) {
        troubles_.spoil(bytes);
    }
    std::int64_t due = way.free_ns;
    if (troubles_.chance(rates.late)) {
        due += troubles_.up_to(rates.late_ns);
    }
    way.last_due_ns = std::max(way.last_due_ns, due);
    const bool twice = troubles_.chance(rates.repeat);
    way.frames.push_back({way.last_due_ns, bytes});
    if (twice) {
        way.frames.push_back({way.last_due_ns, bytes});
    }
    if (troubles_.chance(rates.swap) && way.frames.size() > 1) {
        std::swap(way.frames.back().bytes, way.frames[way.frames.size() - 2].bytes);
    }
}

void SerialLine::receive(std::size_t end, std::int64_t now_ns, std::vector<std::uint8_t>& out) {
    Way& way = to_[end];
    while (!way.frames.empty() && way.frames.front().due_ns <= now_ns) {
        const std::vector<std::uint8_t>& bytes = way.frames.front().bytes;
        out.insert(out.end(), bytes.begin(), bytes.end());
        way.frames.pop_front();
    }
}

void SerialLine::reset(std::size_t end) {
    to_[1 - end] = {};
    to_[end] = {};
}

}  // namespace sc::sim
