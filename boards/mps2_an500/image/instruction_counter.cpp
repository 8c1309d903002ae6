// SPDX-License-Identifier: Apache-2.0
#include "boards/mps2_an500/image/instruction_counter.hpp"

#include "boards/mps2_an500/image/registers.hpp"

namespace sc::mps2_an500 {
namespace {

constexpr std::uint64_t kTickNs = 1'000'000'000 / kCoreClockHz;
constexpr std::uint64_t kInstructionNs = 64;

constexpr std::uint32_t kNapSteps = kCoreClockHz / 20'000;

std::uint32_t cost_of_measuring = 0;

[[gnu::noipa]] void nothing() noexcept {}

/// From writing the counter to reading it. Writing restarts it, so each measurement begins at the same phase: the first
/// step is the reload, and a step shows once it is over, so that `shown` is ceil(elapsed) - 2.
[[gnu::noipa]] std::uint32_t measure(void (*work)()) noexcept {
    systick_value() = 0;
    work();
    const std::uint64_t shown = kSystickMax - systick_value();
    return static_cast<std::uint32_t>((shown + 2) * kTickNs / kInstructionNs);
}

}  // namespace

void start_instruction_counter() noexcept {
    systick_reload() = kSystickMax;
    systick_value() = 0;
    systick_control() = kSystickEnable | kSystickCoreClock;
    cost_of_measuring = measure(nothing);
}

void nap() noexcept {
    systick_control() = 0;
    systick_reload() = kNapSteps;
    systick_value() = 0;
    // With interrupts masked WFI still ends when one becomes pending; the handler does not run.
    asm volatile("cpsid i" ::: "memory");
    systick_control() = kSystickEnable | kSystickInterrupt | kSystickCoreClock;
    asm volatile("wfi" ::: "memory");
    systick_reload() = kSystickMax;
    systick_value() = 0;
    systick_control() = kSystickEnable | kSystickCoreClock;
    interrupt_control() = kClearPendingSystick;
    asm volatile("cpsie i" ::: "memory");
}

std::uint32_t count_instructions(void (*work)()) noexcept { return measure(work) - cost_of_measuring; }

}  // namespace sc::mps2_an500
