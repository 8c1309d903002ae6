// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/slow_lines.hpp"

namespace sc::model {
namespace {

constexpr std::uint32_t kModer = 0x00, kOtyper = 0x04, kPupdr = 0x0C, kIdr = 0x10, kBsrr = 0x18;
constexpr std::uint32_t kCr1 = 0x00, kEgr = 0x14, kCnt = 0x24, kPsc = 0x28, kArr = 0x2C;
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
        case kBsrr: level_ = (level_ & ~(value >> 16U)) | (value & 0xFFFFU); break;  // set wins
        default: note("a register that is not modelled is written"); break;
    }
    been_high_ |= levels();
}

void SlowPort::drive(std::uint32_t pins, std::uint32_t levels) {
    driven_ |= pins;
    outside_ = (outside_ & ~pins) | (levels & pins);
}

Counter::Counter(Machine& machine, const ClockGates& clocks) : machine_(machine), clocks_(clocks) {
    machine.attach(kBase, 0x400, *this);
}

std::uint32_t Counter::count() const {
    if ((words_[kCr1 / 4] & 1U) == 0 || stopped_) {
        return from_;
    }
    const std::int64_t counts = (machine_.now_ns() - started_ns_) * 6 / 25 / (std::int64_t{prescaler_} + 1);
    return from_ + static_cast<std::uint32_t>(counts);
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
        case kPsc:
        case kArr: words_.at(offset / 4) = value; break;
        default: machine_.violation("TIM5: a register that is not modelled is written"); break;
    }
}

}  // namespace sc::model
