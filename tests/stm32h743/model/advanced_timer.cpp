// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/advanced_timer.hpp"

#include <algorithm>

namespace sc::model {
namespace {

constexpr std::uint32_t kBif = 1U << 7U;
constexpr std::uint32_t kBke = 1U << 12U;
constexpr std::uint32_t kBkp = 1U << 13U;
constexpr std::uint32_t kAoe = 1U << 14U;
constexpr std::uint32_t kMoe = 1U << 15U;
constexpr std::uint32_t kOssi = 1U << 10U;
constexpr std::uint32_t kLock = 3U << 8U;
/// What the first level of the lock holds: dead time, break enable and polarity, automatic output, itself.
constexpr std::uint32_t kHeld = 0xFFU | kLock | kBke | kBkp | kAoe;

}  // namespace

std::uint32_t AdvancedTimer::read(std::uint32_t offset) {
    if (offset == 0x24) {
        machine_.violation("TIM1: the counter is not modelled");
    }
    return words_.at(offset / 4);
}

std::int64_t AdvancedTimer::count_now() const { return (machine_.now_ns() - started_ns_) * 6 / 25; }

bool AdvancedTimer::break_active() const {
    const std::uint32_t bdtr = words_[0x44 / 4];
    const bool wired = (words_[0x60 / 4] & 1U) != 0 && port_.function(15) == 1;
    return (bdtr & kBke) != 0 && wired && pin_ == ((bdtr & kBkp) != 0);
}

unsigned AdvancedTimer::mode(unsigned channel) const {
    const std::uint32_t word = words_.at(0x18 / 4 + (channel - 1) / 2);
    const unsigned second = (channel - 1) % 2;
    return ((word >> (4 + 8 * second)) & 7U) | (((word >> (16 + 8 * second)) & 1U) << 3U);
}

bool AdvancedTimer::single(unsigned mode, unsigned channel, std::int64_t count) const {
    const bool below = count - base_ < std::int64_t{shadow_.compare.at(channel - 1)};
    return mode == 7 ? !below : mode == 6 && below;
}

bool AdvancedTimer::reference(unsigned channel, std::int64_t count) const {
    if (mode(channel) == 12) {
        const unsigned other = channel % 2 == 1 ? channel + 1 : channel - 1;
        return single(6, channel, count) || single(mode(other), other, count);
    }
    return single(mode(channel), channel, count);
}

/// The pins as they are from this count on.
void AdvancedTimer::see(std::int64_t count) {
    seen_ = std::max(seen_, count);
    const bool on = (words_[0x44 / 4] & kMoe) != 0;
    const auto level = [&](unsigned channel, unsigned pin) {
        const bool enabled = ((words_[0x20 / 4] >> (4 * (channel - 1))) & 1U) != 0;
        if (port_.function(pin) != 1) {
            return false;
        }
        if (!enabled || (!on && (words_[0x44 / 4] & kOssi) == 0)) {
            machine_.violation("TIM1: an output floats");
        }
        return enabled && on && reference(channel, count);
    };
    const Level now{seen_, level(1, 9), level(3, 13)};
    if (now.gate != last_.gate || now.trigger != last_.trigger) {
        levels.push_back(now);
        last_ = now;
    }
}

void AdvancedTimer::set_break_pin(bool high) {
    pin_ = high;
    if (break_active()) {
        words_[0x44 / 4] &= ~kMoe;
        words_[0x10 / 4] |= kBif;
        see(count_now());
    }
}

void AdvancedTimer::take_bdtr(std::uint32_t value) {
    std::uint32_t& bdtr = words_[0x44 / 4];
    if ((bdtr & kLock) != 0 && ((bdtr ^ value) & kHeld) != 0) {
        machine_.violation("TIM1: what BDTR has locked is written");
        value = (value & ~kHeld) | (bdtr & kHeld);
    }
    if ((value & 0xFCFF0000U) != 0) {
        machine_.violation("TIM1: bits of BDTR that nothing wants");
    }
    bdtr = value;
    if (break_active()) {
        bdtr &= ~kMoe;
        words_[0x10 / 4] |= kBif;
    }
}

void AdvancedTimer::take(std::uint32_t offset, std::uint32_t value) {
    words_.at(offset / 4) = value;
    const auto preloaded = [&](unsigned channel) {
        return ((words_.at(0x18 / 4 + (channel - 1) / 2) >> (3 + 8 * ((channel - 1) % 2))) & 1U) != 0;
    };
    if (offset == 0x2C && (words_[0x00] & (1U << 7U)) == 0) {
        shadow_.reload = value;
    }
    if (offset >= 0x34 && offset <= 0x40) {
        const unsigned channel = (offset - 0x34) / 4 + 1;
        if (!preloaded(channel)) {
            shadow_.compare.at(channel - 1) = value;
        }
    }
    if (((offset >= 0x34 && offset <= 0x40) || offset == 0x2C || offset == 0x30) && (value & ~0xFFFFU) != 0) {
        machine_.violation("TIM1: a count of more than 16 bits");
    }
}

void AdvancedTimer::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (bytes != 4) {
        machine_.violation("TIM1: registers are written as words");
    }
    if (!clocks_.check(ClockGates::kApb2, 0, "TIM1")) {
        return;
    }
    const bool ran = counts();
    switch (offset) {
        case 0x10: words_[0x10 / 4] &= value; break;  // flags fall by 0
        case 0x14:
            if ((value & 1U) != 0) {
                if (ran) {
                    machine_.violation("TIM1: an update by software while it counts");
                }
                base_ = seen_;
                update();
                if (!ran && burst_at_ != kNever) {
                    burst_at_ = kNever;
                    burst();  // it is asked for at once
                }
            }
            if ((value & kBif) != 0) {
                words_[0x44 / 4] &= ~kMoe;
                words_[0x10 / 4] |= kBif;
            }
            break;
        case 0x44: take_bdtr(value); break;
        case 0x4C: {
            const std::uint32_t dcr = words_[0x48 / 4];
            if (!bursting_) {
                machine_.violation("TIM1: DMAR is written outside a burst");
                return;
            }
            take(4 * ((dcr & 31U) + burst_index_), value);
            ++burst_index_;
            return;
        }
        case 0x04:
        case 0x60:
            if ((words_[0x44 / 4] & kLock) != 0 && words_.at(offset / 4) != value) {
                machine_.violation("TIM1: idle levels or the break's source are locked");
                return;
            }
            take(offset, value);
            break;
        case 0x18:
        case 0x1C:
        case 0x20:
        case 0x48:
            if (ran) {
                machine_.violation("TIM1: its set-up is changed while it counts");
            }
            take(offset, value);
            break;
        case 0x2C:
        case 0x30:
        case 0x34:
        case 0x38:
        case 0x3C:
            if (ran) {
                machine_.violation("TIM1: the processor writes what bursts load");
            }
            take(offset, value);
            break;
        case 0x00:
        case 0x0C:
        case 0x28: take(offset, value); break;
        default: machine_.violation("TIM1: a register that is not modelled"); break;
    }
    if (break_active()) {
        words_[0x10 / 4] |= kBif;  // a level: the flag comes back at once
        words_[0x44 / 4] &= ~kMoe;
    }
    if (offset == 0x00 && counts() && !ran) {
        started_ns_ = machine_.now_ns();
        base_ = 0;
        seen_ = 0;
        burst_at_ = kNever;
        levels.clear();
        last_ = {};
        if (words_[0x28 / 4] != 0) {
            machine_.violation("TIM1: a prescaler");
        }
    }
    see(ran && counts() ? count_now() : seen_);
}

std::int64_t AdvancedTimer::next_count() const {
    std::int64_t next = base_ + shadow_.reload + 1;
    for (const std::uint32_t compare : shadow_.compare) {
        const std::int64_t at = base_ + compare;
        if (at > seen_ && at < next) {
            next = at;
        }
    }
    return std::min(next, burst_at_);
}

std::int64_t AdvancedTimer::next_ns() const {
    if (!counts()) {
        return kNever;
    }
    return started_ns_ + (next_count() * 25 + 5) / 6;
}

void AdvancedTimer::act(std::int64_t /*now_ns*/) {
    const std::int64_t count = next_count();
    if (count == burst_at_) {
        burst_at_ = kNever;
        burst();
    }
    if (count == base_ + shadow_.reload + 1) {
        base_ = count;
        if (left_ == 0) {
            update();
        } else {
            --left_;
        }
    }
    see(count);
}

void AdvancedTimer::update() {
    shadow_.reload = words_[0x2C / 4];
    for (unsigned i = 0; i < 4; ++i) {
        shadow_.compare.at(i) = words_.at(0x34 / 4 + i);
    }
    left_ = words_[0x30 / 4];
    words_[0x10 / 4] |= 1U;
    if ((words_[0x44 / 4] & kAoe) != 0 && !break_active()) {
        words_[0x44 / 4] |= kMoe;
    }
    if ((words_[0x0C / 4] & (1U << 8U)) != 0) {
        if (burst_at_ != kNever) {
            machine_.violation("TIM1: an update before the burst of the last one has ended");
        }
        burst_at_ = base_ + kBurstCounts;
        if (counts() && shadow_.reload < kBurstCounts) {
            machine_.violation("TIM1: a period shorter than a burst; it is stopped");
            words_[0] &= ~1U;
        }
    }
}

void AdvancedTimer::burst() {
    bursting_ = true;
    burst_index_ = 0;
    const std::uint32_t words = ((words_[0x48 / 4] >> 8U) & 31U) + 1;
    for (std::uint32_t i = 0; i < words; ++i) {
        dma_.request(kRequest);
    }
    if (burst_index_ != words) {
        machine_.violation("TIM1: a burst that nobody served");
    }
    bursting_ = false;
}

}  // namespace sc::model
