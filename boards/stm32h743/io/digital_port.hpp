// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/hal/io.hpp"

namespace sc::stm32h743 {

/// Slow lines of the cell, all high = healthy or on, inputs pulled down, so that a broken wire reads as the fault and a
/// chip in reset leaves every output off (an external pull-down holds it):
///
/// | in | PD10 laser ready, PD11 no alarm, PD12 shutter open, PD13 shutter closed, PD14 key at setup, PD15 key at
/// production | | in | PG0 to PG3: the source's status pins 11, 12, 16, 21 | | out | PF10 green, PF11 yellow, PF12
/// master oscillator, PF13 guide laser, PF14 shutter, PF15 red |
///
/// E-stop and interlock have lines of their own (optics/safety_lines.hpp). Any context; some accesses each.
class DigitalPort {
public:
    /// Outputs low before they are outputs. False: the set-up did not take.
    [[nodiscard]] static bool start() noexcept;
    /// All inputs but e-stop and interlock, which are left as they are.
    static void sample(DigitalInputs& in) noexcept;
    static void write(const DigitalOutputs& out) noexcept;
    /// All outputs off.
    static void make_safe() noexcept { write({}); }
};

}  // namespace sc::stm32h743
