// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/usart.hpp"

#include <algorithm>

namespace sc::model {
namespace {

using namespace usart_at;

constexpr std::uint32_t kUe = 1, kRe = 1U << 2U, kTe = 1U << 3U, kPce = 1U << 10U, kM0 = 1U << 12U;
constexpr std::uint32_t kRtoen = 1U << 23U, kDmar = 1U << 6U, kDmat = 1U << 7U, kDem = 1U << 14U;
constexpr std::uint32_t kOre = 1U << 3U, kIdle = 1U << 4U, kRxne = 1U << 5U, kTc = 1U << 6U, kTxe = 1U << 7U;
constexpr std::uint32_t kRtof = 1U << 11U, kBusy = 1U << 16U, kTeack = 1U << 21U, kReack = 1U << 22U;
/// Of CR1, what may be written only while it is off: M, OVER8, parity, both driver times, FIFO.
constexpr std::uint32_t kFrozen1 = 0x3BFFD600U & ~0x00004000U;
constexpr std::uint32_t kFrozen2 = 3U << 12U;  // stop bits
constexpr std::uint32_t kFrozen3 = kDem;
constexpr std::int64_t kSecond = 1'000'000'000;
constexpr unsigned kManySignals = 1000;

}  // namespace

UsartModel::UsartModel(Machine& machine, const RegisterWords& clocks, ByteDma* dma, const Instance& instance,
                       std::int64_t kernel_hz)
    : machine_(machine), clocks_(clocks), dma_(dma), instance_(instance), kernel_hz_(kernel_hz) {
    machine.attach(instance.base, kSize, *this);
    if (dma != nullptr) {
        dma->on_ready(instance.rx_request, [this] { pump(); });
        dma->on_ready(instance.tx_request, [this] { pump(); });
    }
}

void UsartModel::note(const std::string& what) {
    machine_.violation("USART at " + std::to_string(instance_.base) + ": " + what);
}

std::int64_t UsartModel::bit_ns() const { return std::int64_t{words_.at(brr / 4)} * kSecond / kernel_hz_; }

std::int64_t UsartModel::character_ns() const {
    const std::int64_t stops = (words_.at(cr2 / 4) >> 12U & 3U) == 2 ? 2 : 1;
    const std::int64_t data = (words_.at(cr1 / 4) & kM0) != 0 ? 9 : 8;
    return (1 + data + stops) * std::int64_t{words_.at(brr / 4)} * kSecond / kernel_hz_;
}

std::int64_t UsartModel::sixteenths(std::uint32_t first) const {
    return (words_.at(cr1 / 4) >> first & 31U) * std::int64_t{words_.at(brr / 4)} * kSecond / (16 * kernel_hz_);
}

void UsartModel::arrives(std::uint8_t byte, std::int64_t begin_ns, std::uint32_t wrong) {
    comes({byte, wrong, begin_ns, begin_ns + character_ns(), true, false, false});
}

/// In the order in which they begin; what is under way stays first.
void UsartModel::comes(const Coming& coming) {
    const auto later = std::ranges::find_if(
        coming_, [&](const Coming& other) { return !other.begun && other.begin_ns > coming.begin_ns; });
    coming_.insert(later, coming);
}

void UsartModel::arrive_from(std::int64_t begin_ns, const std::vector<std::uint8_t>& bytes) {
    for (const std::uint8_t byte : bytes) {
        arrives(byte, begin_ns);
        begin_ns += character_ns();
    }
}

std::uint32_t UsartModel::read(std::uint32_t offset) {
    if (!clocks_.has(instance_.clock_at, instance_.clock)) {
        return 0;
    }
    switch (offset) {
        case isr:
            return flags_ | (!coming_.empty() && coming_.front().begun && coming_.front().heard ? kBusy : 0U) |
                   (kernel_hz_ != 0 && on(kTe) ? kTeack : 0U) | (kernel_hz_ != 0 && on(kRe) ? kReack : 0U);
        case rdr: flags_ &= ~kRxne; return words_.at(rdr / 4);
        default: return words_.at(offset / 4);
    }
}

void UsartModel::write_protected(std::uint32_t offset, std::uint32_t value, std::uint32_t frozen) {
    if ((words_.at(0) & kUe) != 0 && ((words_.at(offset / 4) ^ value) & frozen) != 0) {
        note("settings are written while it is on, at " + std::to_string(offset));
        return;
    }
    words_.at(offset / 4) = value;
}

void UsartModel::write(std::uint32_t offset, std::uint32_t value, unsigned /*bytes*/) {
    if (!clocks_.has(instance_.clock_at, instance_.clock)) {
        note("written without a clock");
        return;
    }
    switch (offset) {
        case cr1:
            write_protected(offset, value, kFrozen1);
            if ((words_.at(cr1 / 4) & kPce) != 0 && (words_.at(cr1 / 4) & kM0) == 0) {
                note("parity takes one of eight bits");
            }
            if ((value & kUe) == 0) {
                flags_ = kTxe | kTc;
                holding_ = shifting_ = false;
                idle_ns_ = timeout_ns_ = kNever;
            } else if (words_.at(brr / 4) < 16) {
                note("turned on without a rate");
            }
            break;
        case cr2: write_protected(offset, value, kFrozen2); break;
        case cr3: write_protected(offset, value, kFrozen3); break;
        case brr: write_protected(offset, value, 0xFFFFU); break;
        case rtor: words_.at(rtor / 4) = value; break;
        case icr: flags_ &= ~(value & 0x0002085FU); break;
        case tdr: transmit(value); break;
        default: note("write to a register that takes none, or is not modelled"); break;
    }
    pump();
    signal();
}

void UsartModel::transmit(std::uint32_t value) {
    if (!on(kTe) || kernel_hz_ == 0) {
        note("a byte is to be sent while the transmitter is off or without its clock");
        return;
    }
    if (holding_) {
        note("a byte is overwritten that waits to be sent");
    }
    held_ = static_cast<std::uint8_t>(value);
    holding_ = true;
    flags_ &= ~(kTxe | kTc);
    if (!shifting_) {
        load();
    }
}

/// From the holding register onto the line.
void UsartModel::load() {
    const std::int64_t now = machine_.now_ns();
    std::int64_t begin = shifting_ ? shift_.end_ns : now;
    if ((words_.at(cr3 / 4) & kDem) != 0 && !shifting_) {
        if (release_ns_ != kNever) {
            release_ns_ = kNever;  // still driven
        } else {
            driven_.push_back({now});
            begin = now + sixteenths(21);
        }
    }
    shift_ = {held_, begin, begin + character_ns()};
    shifting_ = true;
    holding_ = false;
    flags_ |= kTxe;
    if (echo_) {
        comes({held_, 0, shift_.begin_ns, shift_.end_ns, true, false, true});
    }
}

void UsartModel::sent_one(std::int64_t now_ns) {
    sent_.push_back(shift_);
    if (holding_) {
        load();
        return;
    }
    shifting_ = false;
    flags_ |= kTc;
    if ((words_.at(cr3 / 4) & kDem) != 0) {
        release_ns_ = now_ns + sixteenths(16);
    }
}

void UsartModel::receive_one(const Coming& coming) {
    if (!coming.own && !driven_.empty() && coming.begin_ns < driven_.back().end_ns &&
        coming.end_ns > driven_.back().begin_ns) {
        ++collisions_;
    }
    if (!coming.heard || !on(kRe)) {
        return;
    }
    idle_ns_ = coming.end_ns + character_ns();
    timeout_ns_ = kNever;
    if ((words_.at(cr2 / 4) & kRtoen) != 0) {
        timeout_ns_ =
            coming.end_ns + (words_.at(rtor / 4) & 0xFFFFFFU) * std::int64_t{words_.at(brr / 4)} * kSecond / kernel_hz_;
    }
    if ((flags_ & kRxne) != 0) {
        flags_ |= kOre;
        return;
    }
    words_.at(rdr / 4) = coming.byte;
    flags_ |= kRxne | coming.wrong;
}

void UsartModel::pump() {
    if (dma_ == nullptr || kernel_hz_ == 0) {
        return;
    }
    while ((flags_ & kRxne) != 0 && (words_.at(cr3 / 4) & kDmar) != 0 && dma_->serve(instance_.rx_request)) {
    }
    while ((flags_ & kTxe) != 0 && on(kTe) && (words_.at(cr3 / 4) & kDmat) != 0 && dma_->serve(instance_.tx_request)) {
    }
}

/// The interrupt's line is high as long as a flag is whose interrupt is enabled.
void UsartModel::signal() {
    const std::uint32_t enabled = words_.at(cr1 / 4);
    const std::uint32_t from = flags_ & (kIdle | kRxne | kTc | kTxe);
    const bool high = (from & enabled & (kIdle | kRxne | kTc | kTxe)) != 0 ||
                      ((flags_ & kOre) != 0 && (enabled & kRxne) != 0) ||
                      ((flags_ & kRtof) != 0 && (enabled >> 26U & 1U) != 0);
    if (!high) {
        return;
    }
    signals_ = machine_.now_ns() == last_signal_ns_ ? signals_ + 1 : 0;
    last_signal_ns_ = machine_.now_ns();
    if (signals_ < kManySignals) {
        machine_.raise(instance_.interrupt);
    } else if (signals_ == kManySignals) {
        note("its interrupt is never taken back");
    }
}

std::int64_t UsartModel::next_ns() const {
    std::int64_t when = std::min({release_ns_, idle_ns_, timeout_ns_});
    if (shifting_) {
        when = std::min(when, shift_.end_ns);
    }
    if (!coming_.empty()) {
        when = std::min(when, coming_.front().begun ? coming_.front().end_ns : coming_.front().begin_ns);
    }
    return when;
}

void UsartModel::act(std::int64_t now_ns) {
    if (shifting_ && shift_.end_ns <= now_ns) {
        sent_one(now_ns);
    }
    if (release_ns_ <= now_ns) {
        driven_.back().end_ns = release_ns_;
        release_ns_ = kNever;
    }
    if (!coming_.empty() && !coming_.front().begun && coming_.front().begin_ns <= now_ns) {
        Coming& coming = coming_.front();
        coming.begun = true;
        coming.heard = on(kRe);
        if (coming.heard) {
            idle_ns_ = timeout_ns_ = kNever;
        }
    } else if (!coming_.empty() && coming_.front().begun && coming_.front().end_ns <= now_ns) {
        const Coming coming = coming_.front();
        coming_.pop_front();
        receive_one(coming);
    }
    if (idle_ns_ <= now_ns) {
        idle_ns_ = kNever;
        flags_ |= kIdle;
    }
    if (timeout_ns_ <= now_ns) {
        timeout_ns_ = kNever;
        flags_ |= kRtof;
    }
    pump();
    signal();
}

}  // namespace sc::model
