// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/black_box.hpp"

#include <span>

namespace sc::host {
namespace {

/// A tick of which only the low bits are known, not after the newest.
std::int64_t whole_tick(std::int64_t newest, std::uint32_t low, unsigned bits) {
    const std::uint64_t mask = (std::uint64_t{1} << bits) - 1;
    return newest - static_cast<std::int64_t>((static_cast<std::uint64_t>(newest) - low) & mask);
}

}  // namespace

std::uint32_t take_chunk(const link::BlackboxChunk& chunk, BlackBoxContent& content) {
    const double period_s = chunk.period_ns * 1e-9;
    content.frozen = chunk.frozen != 0;
    content.fault = static_cast<Fault>(chunk.fault);
    content.axis = chunk.axis;
    content.newest_s = static_cast<double>(chunk.newest_us) * 1e-6;
    if (chunk.first < chunk.begin) {
        return chunk.begin;  // overwritten meanwhile
    }
    const bool samples = chunk.part == static_cast<std::uint8_t>(link::BlackboxPart::samples);
    const std::size_t bytes = samples ? link::BlackboxSample::kBytes : link::BlackboxEvent::kBytes;
    if (chunk.count == 0 || chunk.count * bytes > chunk.records.size() || chunk.period_ns == 0) {
        return chunk.end;
    }
    const auto newest = static_cast<std::int64_t>((chunk.newest_us * 1000 + chunk.period_ns / 2) / chunk.period_ns);
    const std::span<const std::uint8_t> records(chunk.records);
    for (std::size_t i = 0; i < chunk.count; ++i) {
        if (samples) {
            const auto sample = link::unpack_sample(records.subspan(i * bytes).first<link::BlackboxSample::kBytes>());
            const std::int64_t tick = whole_tick(newest, sample.tick, 16);
            content.samples.push_back({static_cast<double>(tick) * period_s, sample});
        } else {
            const auto event = link::unpack_event(records.subspan(i * bytes).first<link::BlackboxEvent::kBytes>());
            // Of a box that still writes, an event may be a little newer than its newest sample.
            const std::int64_t latest = newest + (std::int64_t{1} << 16U);
            content.events.push_back({static_cast<double>(whole_tick(latest, event.tick, 32)) * period_s, event});
        }
    }
    return chunk.first + chunk.count;
}

}  // namespace sc::host
