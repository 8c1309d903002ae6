// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// Counts executed instructions by SysTick. QEMU with `-icount shift=6` gives each instruction 64 ns of virtual time,
/// and SysTick at 25 MHz shows 40 ns, so single instructions are told apart. Up to 10 million instructions. Anywhere
/// else than in QEMU the figure would be cycles divided by 1.6, and not exact.

namespace sc::mps2_an500 {

/// Starts SysTick and measures what measuring costs. Interrupts must be off.
void start_instruction_counter() noexcept;

/// Instructions that `work()` executes, its own return not counted.
[[nodiscard]] std::uint32_t count_instructions(void (*work)()) noexcept;

/// Sleeps for 50 µs of SysTick, which QEMU takes as of the PC's clock. No interrupt handler runs.
void nap() noexcept;

}  // namespace sc::mps2_an500
