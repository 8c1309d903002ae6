// SPDX-License-Identifier: Apache-2.0
#include "firmware/controller/black_box.hpp"

#include <algorithm>
#include <span>

namespace sc {
namespace {

/// Copies whole records [first, end) of a ring, the record of number n in place n modulo Size, as far as they fit.
template <std::size_t Bytes, std::size_t Size>
void copy_records(const std::array<std::array<std::uint8_t, Bytes>, Size>& ring, std::uint32_t end,
                  link::BlackboxChunk& out) noexcept {
    out.end = end;
    out.begin = end > Size ? end - static_cast<std::uint32_t>(Size) : 0;
    if (out.first < out.begin || out.first >= end) {
        return;
    }
    constexpr std::size_t kMost = link::BlackboxChunk::kBytes / Bytes;
    const std::size_t count = std::min<std::size_t>(end - out.first, kMost);
    for (std::size_t i = 0; i < count; ++i) {
        const auto& record = ring[(out.first + i) % Size];
        std::copy(record.begin(), record.end(), out.records.begin() + static_cast<std::ptrdiff_t>(i * Bytes));
    }
    out.count = static_cast<std::uint8_t>(count);
}

}  // namespace

void BlackBox::add(std::int64_t tick, link::BlackboxSample sample) noexcept {
    if (frozen_) {
        return;
    }
    sample.tick = static_cast<std::uint16_t>(tick & 0xFFFF);
    link::pack(sample, std::span(samples_[samples_end_ % kSamples]));
    ++samples_end_;
    newest_tick_ = tick;
}

void BlackBox::note(std::int64_t tick, link::BlackboxKind kind, std::uint8_t a, std::uint16_t b) noexcept {
    if (frozen_) {
        return;
    }
    const link::BlackboxEvent event{static_cast<std::uint32_t>(tick & 0xFFFF'FFFF), static_cast<std::uint8_t>(kind), a,
                                    b};
    link::pack(event, std::span(events_[events_end_ % kEvents]));
    ++events_end_;
}

void BlackBox::freeze(std::int64_t tick, Fault fault, std::uint8_t axis, const link::BlackboxSample& last) noexcept {
    add(tick, last);
    frozen_ = true;
    fault_ = fault;
    axis_ = axis;
}

void BlackBox::thaw() noexcept {
    frozen_ = false;
    fault_ = Fault::none;
    axis_ = 0xFF;
    samples_end_ = events_end_ = 0;
}

void BlackBox::read(const link::BlackboxRequest& request, link::BlackboxChunk& out) const noexcept {
    out.part = request.part;
    out.first = request.first;
    out.frozen = frozen_ ? 1 : 0;
    out.fault = static_cast<std::uint8_t>(fault_);
    out.axis = axis_;
    out.newest_us = static_cast<std::uint64_t>(newest_tick_ > 0 ? newest_tick_ * period_ns_ / 1000 : 0);
    out.period_ns = static_cast<std::uint32_t>(period_ns_);
    if (request.part == static_cast<std::uint8_t>(link::BlackboxPart::samples)) {
        copy_records(samples_, samples_end_, out);
    } else if (request.part == static_cast<std::uint8_t>(link::BlackboxPart::events)) {
        copy_records(events_, events_end_, out);
    }
}

}  // namespace sc
