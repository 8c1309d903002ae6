// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/interrupt_control.hpp"

namespace sc::model {

using namespace nvic_fields;

InterruptControl::InterruptControl(Machine& machine) : machine_(machine), nvic_(*this, kNvic), scb_(*this, kScb) {
    machine.attach(kNvic, 0x400, nvic_);
    machine.attach(kScb, 0x100, scb_);
}

void InterruptControl::preset(unsigned number, bool enabled, bool pending, std::uint8_t priority) {
    enabled_.at(number) = enabled;
    pending_.at(number) = pending;
    priority_.at(number) = priority;
}

void InterruptControl::write(std::uint32_t at, std::uint32_t value, unsigned bytes) {
    if (at >= kPriority.address && at < kPriority.address + kInterrupts) {
        if (bytes != 1) {
            return say("priorities are written four at a time");
        }
        if ((value & 15U) != 0) {
            say("a bit of priority that the chip does not have");
        }
        const unsigned number = at - kPriority.address;
        if (enabled_.at(number)) {
            say("a priority changes while its interrupt is enabled");
        }
        priority_.at(number) = static_cast<std::uint8_t>(value);
        set_.at(number) = true;
        return;
    }
    if (at == kPendSv.address + 2 && bytes == 1) {
        servo_priority_ = static_cast<std::uint8_t>(value);
        return;
    }
    if (bytes != 4) {
        return say("written by parts");
    }
    switch (at) {
        case kGroup.address:
            if ((value & kKey.mask()) != 0x05FA'0000) {
                return say("AIRCR is written without its key");
            }
            group_ = (value & kGroup.mask()) >> kGroup.first;
            return;
        case kMemory.address: fault_priorities_ = value; return;
        case kPend.address:
            if ((value & ~kPend.mask()) != 0) {
                say("a bit of ICSR that is not modelled");
            }
            servo_asked_ = servo_asked_ || (value & kPend.mask()) != 0;
            return;
        default: write_bits(at, value);
    }
}

void InterruptControl::write_bits(std::uint32_t at, std::uint32_t value) {
    const std::uint32_t offset = (at - kNvic) & 0x7FU;
    const std::uint32_t bank = at - offset;
    if (offset >= 20 || (bank != kEnable.address && bank != kDisable.address && bank != kForget.address)) {
        return say("a register that is not modelled");
    }
    for (unsigned bit = 0; bit < 32; ++bit) {
        const unsigned number = offset * 8 + bit;
        if ((value >> bit & 1U) == 0 || number >= kInterrupts) {
            continue;
        }
        if (bank == kDisable.address) {
            enabled_.at(number) = false;
        } else if (bank == kForget.address) {
            pending_.at(number) = false;
        } else {
            if (!set_.at(number)) {
                say("an interrupt is enabled that has no priority yet");
            }
            if (pending_.at(number)) {
                say("an interrupt is enabled that is pending from before");
            }
            enabled_.at(number) = true;
        }
    }
}

}  // namespace sc::model
