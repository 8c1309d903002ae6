// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/external_lines.hpp"

namespace sc::model {

void PortChoice::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (bytes != 4 || offset < 0x08 || offset > 0x14 || (value & ~0xFFFFU) != 0) {
        machine_.violation("SYSCFG: only ports of lines are chosen");
    }
    if (clocks_.check(ClockGates::kApb4, 1, "SYSCFG")) {
        words_.at(offset / 4) = value;
    }
}

std::uint32_t EdgeLines::read(std::uint32_t offset) {
    switch (offset) {
        case 0x00: return rising_;
        case 0x04: return falling_;
        case 0x80: return mask_;
        case 0x88: return pending_;
        default: machine_.violation("EXTI: a register that is not modelled"); return 0;
    }
}

void EdgeLines::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (bytes != 4) {
        machine_.violation("EXTI: registers are words");
    }
    switch (offset) {
        case 0x00:
        case 0x04:
            if ((mask_ & value & (~rising_ & ~falling_)) != 0) {
                machine_.violation("EXTI: an edge is chosen while its line may interrupt");
            }
            (offset == 0x00 ? rising_ : falling_) = value;
            pending_ |= value & 0x180U;  // the choice may itself look like an edge
            break;
        case 0x80:
            mask_ = value;
            interrupt();
            break;
        case 0x88: pending_ &= ~value; break;
        default: machine_.violation("EXTI: a register that is not modelled"); break;
    }
}

void EdgeLines::set_pin(unsigned pin, bool high) {
    const std::uint32_t bit = 1U << pin;
    const bool was = (pins_ & bit) != 0;
    pins_ = (pins_ & ~bit) | (high ? bit : 0);
    port_.set_input(pin, high);
    if (was == high || choice_.port_of(pin) != 4) {
        return;
    }
    if (((high ? rising_ : falling_) & bit) != 0) {
        pending_ |= bit;
        interrupt();
    }
}

void EdgeLines::interrupt() {
    if ((pending_ & mask_) != 0) {
        machine_.raise(kInterrupt5To9);
    }
}

void PeriodTimer::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (bytes != 4) {
        machine_.violation("TIM7: registers are written as words");
    }
    if (!clocks_.check(ClockGates::kApb1l, 5, "TIM7")) {
        return;
    }
    const bool ran = (words_[0] & 1U) != 0;
    switch (offset) {
        case 0x10: words_[4] &= value; return;
        case 0x14:
            words_[4] |= value & 1U;
            interrupt();
            return;
        case 0x28:
        case 0x2C:
            if (ran) {
                machine_.violation("TIM7: its period is changed while it counts");
            }
            break;
        case 0x00:
        case 0x0C: break;
        default: machine_.violation("TIM7: a register that is not modelled"); return;
    }
    words_.at(offset / 4) = value;
    if (offset == 0x0C) {
        interrupt();
    }
    if (!ran && (words_[0] & 1U) != 0) {
        started_ns_ = machine_.now_ns();
        ticks_ = std::int64_t{words_[0x2C / 4]} + 1;
        if (words_[0x28 / 4] != 0) {
            machine_.violation("TIM7: a prescaler");
        }
    }
}

std::int64_t PeriodTimer::next_ns() const {
    return (words_[0] & 1U) != 0 ? started_ns_ + (ticks_ * 25 + 5) / 6 : kNever;
}

void PeriodTimer::act(std::int64_t /*now_ns*/) {
    ticks_ += std::int64_t{words_[0x2C / 4]} + 1;
    if ((words_[4] & 1U) != 0) {
        machine_.violation("TIM7: the flag of the last period stands");
    }
    words_[4] |= 1U;
    interrupt();
}

void PeriodTimer::interrupt() {
    if ((words_[4] & words_[3] & 1U) != 0) {
        machine_.raise(kInterrupt);
    }
}

}  // namespace sc::model
