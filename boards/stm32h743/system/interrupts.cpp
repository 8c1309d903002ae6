// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/system/interrupts.hpp"

#include <algorithm>

#include "boards/stm32h743/registers/nvic.hpp"

namespace sc::stm32h743 {
namespace {

void enable(unsigned number) noexcept {
    const Address word = 4 * (number / 32);
    const std::uint32_t bit = 1U << (number % 32);
    write32(nvic::kIcpr + word, bit);  // what came before the driver was ready
    write32(nvic::kIser + word, bit);
}

}  // namespace

void prepare_interrupts() noexcept {
    for (unsigned i = 0; i < nvic::kWords; ++i) {
        write32(nvic::kIcer + 4 * i, ~0U);
        write32(nvic::kIcpr + 4 * i, ~0U);
    }
    barrier();
    instruction_barrier();
    write32(nvic::kAircr, nvic::kKey | nvic::kAllPreempt);
    write32(nvic::kFaultPriorities, 0);
    for (const Context& one : kContexts) {
        const auto byte = static_cast<std::uint8_t>(one.priority << nvic::kPriorityShift);
        if (one.number >= 0) {
            write8(nvic::kIpr + static_cast<Address>(one.number), byte);
        } else if (one.number == kPendSv) {
            write8(nvic::kPendSvPriority, byte);
        }
    }
    write8(nvic::kIpr, 0);  // the watchdog's warning
}

bool enable_interrupt(int number) noexcept {
    const bool known = std::ranges::any_of(kContexts, [&](const Context& one) { return one.number == number; });
    if (number < 0 || !known) {
        return false;
    }
    enable(static_cast<unsigned>(number));
    return true;
}

void enable_warning() noexcept { enable(0); }

void ask_for_servo_step() noexcept {
    write32(nvic::kIcsr, nvic::kPendPendSv);
    barrier();
}

}  // namespace sc::stm32h743
