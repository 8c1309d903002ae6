// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/optics/pulse_segments.hpp"

namespace sc::stm32h743 {
namespace {

/// Beyond this offset a trigger is only known to be far; six times it fits 32 bits.
constexpr std::int64_t kFarNs256 = 2'700'000 * std::int64_t{256};
constexpr std::uint32_t kFar = 648'000;
constexpr std::int64_t kMostPeriod = 0xFFFF'FFFF;

}  // namespace

void PulseSegments::begin(std::int64_t origin_ns) noexcept {
    drop();
    base_ns_ = origin_ns - origin_ns % kWindowNs;
    at_ = static_cast<std::uint32_t>((origin_ns - base_ns_) * 6 / 25);
}

void PulseSegments::drop() noexcept {
    first_ = 0;
    size_ = 0;
    triggers_ = false;
    gate_open_ = false;
}

bool PulseSegments::add(const LaserRun& run) noexcept {
    if (run.count == 0 || run.pick == 0) {
        return true;
    }
    if (size_ == kRuns) {
        return false;
    }
    runs_[(first_ + size_) % kRuns] = run;
    ++size_;
    if (size_ == 1) {
        pulse_ = 0;
        pulse_ns256_ = run.t0_ns * 256;
        load();
    }
    return true;
}

/// 240 MHz are 6 counts in 25 ns; to the nearest count. 32-bit arithmetic, since offsets are below kFarNs256.
std::uint32_t PulseSegments::count_of(std::int64_t ns256) const noexcept {
    const std::int64_t offset = ns256 - base_ns_ * 256;
    if (offset < 0) {
        return 0;
    }
    if (offset >= kFarNs256) {
        return kFar;
    }
    return (static_cast<std::uint32_t>(offset) * 6U + 3200U) / 6400U;
}

void PulseSegments::rebase() noexcept {
    while (at_ >= kWindowCounts) {
        at_ -= kWindowCounts;
        base_ns_ += kWindowNs;
    }
}

/// The period behind pulse_, split into the source's triggers.
void PulseSegments::load() noexcept {
    const LaserRun& run = runs_[first_];
    std::int64_t period = run.period_ns256 + std::int64_t{run.change_ns256} * pulse_;
    period = period < 0 ? 0 : period;
    period = period > kMostPeriod ? kMostPeriod : period;
    step_ns256_ = static_cast<std::uint32_t>(period) / run.pick;
    rest_ns256_ = static_cast<std::uint32_t>(period) - step_ns256_ * run.pick;
    part_ = 0;
}

void PulseSegments::step() noexcept {
    const LaserRun& run = runs_[first_];
    ++part_;
    if (part_ < run.pick) {
        return;
    }
    pulse_ns256_ += run.period_ns256 + std::int64_t{run.change_ns256} * pulse_;
    ++pulse_;
    if (pulse_ < run.count) {
        load();
        return;
    }
    first_ = (first_ + 1) % kRuns;
    --size_;
    if (size_ > 0) {
        pulse_ = 0;
        pulse_ns256_ = runs_[first_].t0_ns * 256;
        load();
    }
}

/// The next trigger that can leave; those that cannot are dropped on the way to it.
std::optional<PulseSegments::Trigger> PulseSegments::peek() noexcept {
    while (size_ > 0) {
        const LaserRun& run = runs_[first_];
        const std::uint32_t share = rest_ns256_ * part_ / run.pick;
        const std::int64_t ns256 = pulse_ns256_ + std::int64_t{step_ns256_} * part_ + share;
        const Trigger trigger{count_of(ns256), part_ == 0};
        bool room = trigger.count >= at_ + kShortestSegment || (!triggers_ && trigger.count == at_);
        if (!trigger.picked && pulse_ + 1U == run.count && size_ > 1) {
            // The pulse that the next run begins with goes before this trigger, which makes none.
            room = room && trigger.count + kShortestSegment <= count_of(runs_[(first_ + 1) % kRuns].t0_ns * 256);
        }
        if (room) {
            return trigger;
        }
        refused_ += trigger.picked ? 1U : 0U;
        step();
    }
    return std::nullopt;
}

Segment PulseSegments::make(std::uint32_t length, bool opens) const noexcept {
    const std::uint32_t half = length / 2;
    const std::uint32_t reach = half < kGateCounts ? half : kGateCounts;
    Segment segment{length - 1, 0, gate_open_ ? reach : 0, opens ? length - reach : kNoCount,
                    triggers_ ? kTriggerCounts : 0};
    if (gate_open_ && opens && half <= kGateCounts) {
        segment.gate_until = kNoCount;  // no edge where the one part ends and the other begins
        segment.gate_from = kNoCount;
    }
    return segment;
}

std::optional<Segment> PulseSegments::next(std::int64_t horizon_ns) noexcept {
    rebase();
    const std::uint32_t horizon = count_of(horizon_ns * 256);
    std::optional<Segment> made;
    std::uint32_t total = 0;
    while (at_ < horizon) {
        std::optional<Trigger> trigger = peek();
        if (trigger && trigger->count == at_) {
            triggers_ = true;
            gate_open_ = trigger->picked;
            step();
            trigger = peek();
        }
        std::uint32_t length = kLongestSegment;
        bool reaches = false;
        if (trigger) {
            const std::uint32_t distance = trigger->count - at_;
            reaches = distance <= kLongestSegment;
            if (reaches) {
                length = distance;
            } else if (distance < kLongestSegment + kShortestSegment) {
                length = kLongestSegment - kShortestSegment;
            }
        }
        const Segment segment = make(length, reaches && trigger->picked);
        if (made && (segment.reload != made->reload || segment.gate_until != made->gate_until ||
                     segment.gate_from != made->gate_from || segment.trigger != made->trigger ||
                     total + length > kLongestSegment)) {
            break;
        }
        if (made) {
            ++made->repeats;
        } else {
            made = segment;
        }
        total += length;
        at_ += length;
        triggers_ = reaches;
        gate_open_ = reaches && trigger->picked;
        if (reaches) {
            step();
        }
    }
    return made;
}

}  // namespace sc::stm32h743
