// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/slow_lines.hpp"

#include <algorithm>

namespace sc::model {
namespace {

constexpr std::uint32_t kModer = 0x00, kOtyper = 0x04, kPupdr = 0x0C, kIdr = 0x10, kBsrr = 0x18, kAfrl = 0x20,
                        kAfrh = 0x24;
constexpr std::uint32_t kCr1 = 0x00, kDier = 0x0C, kEgr = 0x14, kCnt = 0x24, kPsc = 0x28, kArr = 0x2C;
constexpr std::uint32_t kCcr1 = 0x34, kCcr2 = 0x38, kDcr = 0x48, kDmar = 0x4C;
constexpr unsigned kTim5Clock = 3;

}  // namespace

SlowPort::SlowPort(Machine& machine, const ClockGates& clocks, unsigned number)
    : machine_(machine), clocks_(clocks), number_(number) {
    machine.attach(kBase + kStep * number, kStep, *this);
}

void SlowPort::note(const std::string& what) {
    machine_.violation(std::string("GPIO") + static_cast<char>('A' + number_) + ": " + what);
}

std::uint32_t SlowPort::read(std::uint32_t offset) {
    if (!clocks_.has(ClockGates::kAhb4, 1U << number_)) {
        note("read without its clock");
        return 0;
    }
    switch (offset) {
        case kModer: return mode_;
        case kOtyper: return type_;
        case kPupdr: return pull_;
        case kAfrl:
        case kAfrh: return function_.at((offset - kAfrl) / 4);
        case kIdr: {
            std::uint32_t levels = 0;
            for (unsigned pin = 0; pin < 16; ++pin) {
                const std::uint32_t mode = mode_ >> (2 * pin) & 3U;
                const bool out = mode == 1 && (level_ >> pin & 1U) != 0;
                const bool in =
                    (driven_ >> pin & 1U) != 0 ? (outside_ >> pin & 1U) != 0 : (pull_ >> (2 * pin) & 3U) == 1;
                if (mode == 0 && (driven_ >> pin & 1U) == 0 && (pull_ >> (2 * pin) & 3U) == 0) {
                    note("pin " + std::to_string(pin) + " floats");
                }
                levels |= (mode == 1 ? out : mode != 3 && in) ? 1U << pin : 0U;
            }
            return levels;
        }
        default: return 0;
    }
}

void SlowPort::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (!clocks_.check(ClockGates::kAhb4, number_, "GPIO")) {
        return;
    }
    if (bytes != 4) {
        note("registers are words");
    }
    const std::uint32_t before = levels();
    switch (offset) {
        case kModer:
            mode_ = value;
            outputs_ = 0;
            for (unsigned pin = 0; pin < 16; ++pin) {
                outputs_ |= (mode_ >> (2 * pin) & 3U) == 1 ? 1U << pin : 0U;
            }
            break;
        case kOtyper: type_ = value; break;
        case kPupdr: pull_ = value; break;
        case kAfrl:
        case kAfrh: function_.at((offset - kAfrl) / 4) = value; break;
        case kBsrr: level_ = (level_ & ~(value >> 16U)) | (value & 0xFFFFU); break;  // set wins
        default: note("a register that is not modelled is written"); break;
    }
    been_high_ |= levels();
    if (on_change && levels() != before) {
        on_change(machine_.now_ns(), levels());
    }
}

int SlowPort::function(unsigned pin) const {
    return (mode_ >> (2 * pin) & 3U) != 2 ? -1 : static_cast<int>(function_.at(pin / 8) >> (4 * (pin % 8)) & 15U);
}

void SlowPort::drive(std::uint32_t pins, std::uint32_t levels) {
    driven_ |= pins;
    outside_ = (outside_ & ~pins) | (levels & pins);
}

Counter::Counter(Machine& machine, const ClockGates& clocks, DmaModel* dma)
    : machine_(machine), clocks_(clocks), dma_(dma) {
    machine.attach(kBase, 0x400, *this);
}

std::uint32_t Counter::count() const {
    if ((words_[kCr1 / 4] & 1U) == 0 || stopped_) {
        return from_;
    }
    const std::int64_t counts = (machine_.now_ns() - started_ns_) * 6 / 25 / (std::int64_t{prescaler_} + 1);
    return from_ + static_cast<std::uint32_t>(counts);
}

bool Counter::asks(unsigned channel) const {
    return (words_[kCr1 / 4] & 1U) != 0 && !stopped_ && (words_[kDier / 4] >> (9U + channel) & 1U) != 0;
}

/// When the counter comes to the compare value: the first moment after the last one.
std::int64_t Counter::due_ns(unsigned channel) const {
    const std::int64_t now = machine_.now_ns();
    const std::uint32_t ahead = words_[kCcr1 / 4 + channel] - count();
    const std::int64_t counts = (now - started_ns_) * 6 / 25 + ahead;
    const std::int64_t when = started_ns_ + (counts * 25 + 5) / 6;
    constexpr std::int64_t kLap = (std::int64_t{1} << 32U) * 25 / 6;
    return when <= last_ns_.at(channel) || (ahead == 0 && when < now) ? when + kLap : when;
}

void Counter::schedule() {
    next_ns_ = kNever;
    for (unsigned channel = 0; channel < 2; ++channel) {
        if (asks(channel)) {
            next_ns_ = std::min(next_ns_, due_ns(channel));
        }
    }
}

void Counter::act(std::int64_t now_ns) {
    for (unsigned channel = 0; channel < 2; ++channel) {
        if (asks(channel) && due_ns(channel) <= now_ns) {
            last_ns_.at(channel) = now_ns;
            ask(channel);
        }
    }
    schedule();
}

void Counter::ask(unsigned channel) {
    if (dma_ == nullptr) {
        machine_.violation("TIM5: asks for DMA");
        return;
    }
    if (channel == 0) {
        dma_->request(kRequest1);
        return;
    }
    burst_ = 0;
    for (std::uint32_t i = 0; i <= (words_[kDcr / 4] >> 8U & 31U); ++i) {
        dma_->request(kRequest2);
    }
}

std::uint32_t Counter::read(std::uint32_t offset) { return offset == kCnt ? count() : words_.at(offset / 4); }

void Counter::write(std::uint32_t offset, std::uint32_t value, unsigned /*bytes*/) {
    if (!clocks_.check(ClockGates::kApb1l, kTim5Clock, "TIM5")) {
        return;
    }
    switch (offset) {
        case kCr1:
            from_ = count();
            words_[kCr1 / 4] = value;
            started_ns_ = machine_.now_ns();
            if ((value & 1U) != 0 && words_[kArr / 4] != 0xFFFFFFFFU) {
                machine_.violation("TIM5: started with a short period");
            }
            break;
        case kEgr:
            from_ = 0;
            prescaler_ = words_[kPsc / 4];
            started_ns_ = machine_.now_ns();
            break;
        case kDmar: {
            const std::uint32_t first = words_[kDcr / 4] & 31U;
            const std::uint32_t at = 4 * (first + burst_++);
            if (at != kCcr1 && at != kCcr2) {
                machine_.violation("TIM5: a burst into a register that takes none");
                return;
            }
            words_.at(at / 4) = value;
            break;
        }
        case kDier:
        case kPsc:
        case kArr:
        case kCcr1:
        case kCcr2:
        case kDcr: words_.at(offset / 4) = value; break;
        default: machine_.violation("TIM5: a register that is not modelled is written"); break;
    }
    schedule();
}

}  // namespace sc::model
