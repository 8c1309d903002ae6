// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/cell/waves.hpp"

#include <algorithm>
#include <iterator>

namespace sc::stm32h743::cell {
namespace {

constexpr unsigned kBits = 20;
constexpr unsigned kClock = 2, kSync = 3, kX = 4, kZ = 5;
constexpr bool has(std::uint32_t levels, unsigned pin) { return (levels >> pin & 1U) != 0; }

}  // namespace

std::optional<GalvoLine::Frame> GalvoLine::edge(std::int64_t ns, std::uint32_t before, std::uint32_t after) {
    if (!has(before, kClock) && has(after, kClock) && bits_ == 0) {
        frame_.begin_ns = ns;
    }
    if (!has(before, kClock) || has(after, kClock)) {
        return std::nullopt;
    }
    frame_.word_x = frame_.word_x << 1U | (has(after, kX) ? 1U : 0U);
    frame_.word_z = frame_.word_z << 1U | (has(after, kZ) ? 1U : 0U);
    ++bits_;
    if (has(after, kSync)) {
        return std::nullopt;
    }
    const bool whole = bits_ == kBits;
    broken_ += whole ? 0U : 1U;
    const Frame frame = frame_;
    frame_ = {};
    bits_ = 0;
    return whole ? std::optional(frame) : std::nullopt;
}

void TriggerLine::take(std::vector<model::AdvancedTimer::Level>& levels, std::vector<Trigger>& out) {
    for (const model::AdvancedTimer::Level& level : levels) {
        if (level.trigger && !trigger_) {
            out.push_back({level.count - origin_, level.gate});
        }
        trigger_ = level.trigger;
    }
    levels.clear();
}

void PowerLine::change(std::int64_t ns, std::uint32_t levels) {
    constexpr unsigned kLatch = 8;
    constexpr std::uint32_t kByte = 0xFF;
    constexpr std::int64_t kCountNs = 5;  // each edge is at a whole count
    const bool was_up = has(levels_, kLatch);
    if (((levels ^ levels_) & kByte) != 0) {
        laid_ns_ = ns;
        bad_ += was_up ? 1U : 0U;
    }
    if (!was_up && has(levels, kLatch)) {
        rose_ns_ = ns;
        bad_ += ns - laid_ns_ < setup_ns_ - kCountNs ? 1U : 0U;
        taken_.push_back({ns, static_cast<int>(levels & kByte)});
    }
    if (was_up && !has(levels, kLatch)) {
        bad_ += ns - rose_ns_ < width_ns_ - kCountNs ? 1U : 0U;
    }
    levels_ = levels;
}

int PowerLine::at(std::int64_t ns) const {
    const auto after = std::ranges::upper_bound(taken_, ns, {}, [](const Taken& taken) { return taken.ns; });
    return after == taken_.begin() ? -1 : std::prev(after)->byte;
}

}  // namespace sc::stm32h743::cell
