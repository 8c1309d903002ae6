// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/system/clock_plan.hpp"

namespace sc::stm32h743 {

/// Why the chip runs on HSI.
enum class ClockFault : std::uint8_t {
    none = 0,
    old_revision = 1,  ///< made before V: no VOS0
    supply = 2,        ///< not from the LDO, or its voltage does not come
    scale1 = 3,        ///< VOS1 does not come
    scale0 = 4,        ///< VOS0 does not come
    no_hse = 5,        ///< no clock from outside: jumpers of the MCO, or the ST-Link sleeps
    pll1 = 6,          ///< it does not lock
    pll2 = 7,
    switch_over = 8,  ///< the core does not take PLL1
    hsi = 9,          ///< not even HSI can be had; the core runs on what it had
    wait_states = 10  ///< the flash does not take them
};

struct Clocks {
    ClockFault fault = ClockFault::none;
    Frequencies frequencies = kSlow;  ///< in force; not known with ClockFault::hsi
};

/// From any state that a reset or a boot loader leaves, on HSI or PLL1, to the clock tree of clock_plan.hpp, or to HSI
/// with a reason. Once, at the start, with interrupts off. Some 0.4 ms; 0.6 s at most, when HSE does not come. Orders:
/// reference manual, sections System supply startup, Voltage scaling (VOS0), PLL initialization, Clock switches.
[[nodiscard]] Clocks start_clocks() noexcept;

}  // namespace sc::stm32h743
