// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/hal/io.hpp"

namespace sc::stm32h743 {

/// Slow lines of the cell, all high = healthy or on, inputs pulled down, so that a broken wire reads as the fault and a
/// chip in reset leaves every output off (an external pull-down holds it):
///
/// | in | PG0 laser ready, PG1 no alarm, PG2 shutter open, PG3 shutter closed, PG4 key at setup, PG5 key at production
/// | | in | PF11 to PF14: the source's status pins 11, 12, 16, 21 | | out | PD10 master oscillator, PD11 guide laser,
/// PD12 red, PD13 yellow, PD14 green, PD15 shutter |
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
