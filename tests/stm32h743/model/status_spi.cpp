// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/status_spi.hpp"

namespace sc::model {
namespace {

constexpr std::uint32_t kCr1 = 0x00, kCfg1 = 0x08, kCfg2 = 0x0C, kSr = 0x14, kIfcr = 0x18, kRxdr = 0x30;
constexpr std::uint32_t kOverrun = 1U << 6U;
constexpr std::uint32_t kReceiveDma = 1U << 14U;
constexpr unsigned kClockBit = 15;
constexpr unsigned kFrame = 20;

}  // namespace

StatusSpi::StatusSpi(Machine& machine, const ClockGates& clocks, DmaModel& dma, const SlowPort& port_c)
    : machine_(machine), clocks_(clocks), dma_(dma), port_(port_c) {
    machine.attach(kBase, 0x400, *this);
    words_[kCfg1 / 4] = 0x00070007;  // as the reset leaves it
}

std::uint32_t StatusSpi::read(std::uint32_t offset) {
    if (offset == kRxdr) {
        waits_ = false;
        return received_;
    }
    return words_.at(offset / 4);
}

void StatusSpi::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (!clocks_.check(ClockGates::kApb1l, kClockBit, "SPI3")) {
        return;
    }
    if (bytes != 4) {
        note("registers are words");
    }
    switch (offset) {
        case kCr1:
            if ((value & 1U) != 0 && !enabled()) {
                const std::uint32_t config2 = words_[kCfg2 / 4];
                if ((config2 >> 17U & 3U) != 2 || (config2 & 1U << 22U) != 0 || (config2 & 1U << 26U) == 0 ||
                    (config2 & 3U << 24U) != 0) {
                    note("enabled as something else than a receiver that samples with the rising clock");
                }
                if (port_.function(10) != 6 || port_.function(12) != 6) {
                    note("enabled without its pins");
                }
                shift_ = 0;
                bits_ = 0;
                waits_ = false;
            }
            words_[kCr1 / 4] = value;
            break;
        case kCfg1:
        case kCfg2:
            if (enabled()) {
                note("settings are written while it is on");
                return;
            }
            words_.at(offset / 4) = value;
            break;
        case kIfcr: words_[kSr / 4] &= ~value; break;
        default: note("a register that is not modelled is written"); break;
    }
}

void StatusSpi::clock(bool data) {
    if (!enabled()) {
        return;
    }
    const unsigned size = (words_[kCfg1 / 4] & 31U) + 1;
    shift_ = (shift_ << 1U | (data ? 1U : 0U)) & 0xFFFFFU;
    if (++bits_ < size) {
        return;
    }
    bits_ = 0;
    if (waits_) {
        words_[kSr / 4] |= kOverrun;
        return;
    }
    received_ = shift_;
    waits_ = true;
    if ((words_[kCfg1 / 4] & kReceiveDma) != 0) {
        dma_.request(kRequest);
    }
}

void StatusLine::clock() {
    if (bit_ % kFrame == 0) {
        frame_ = 1U << 17U | std::uint32_t{next_} << 1U;
        frame_ |= static_cast<std::uint32_t>(__builtin_popcount(frame_)) & 1U;
    }
    const bool data = (frame_ >> (kFrame - 1 - bit_ % kFrame) & 1U) != 0;
    bit_ = (bit_ + 1) % kFrame;
    spi_.clock(hangs_ ? level_ : data);
}

}  // namespace sc::model
