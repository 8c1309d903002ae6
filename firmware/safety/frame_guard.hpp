// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/hal/io.hpp"

namespace sc::safety {

/// The guard between ticks: a board calls it at 10 kHz or more with the inputs as they are now. The gate closes unless
/// the last tick allowed it and every input is healthy; the head must acknowledge its position only while it did.
/// `causes` names what is wrong whether or not the gate was allowed; the board hands the causes it has seen to the next
/// tick. ISR context; some ten comparisons and one table, no state.
[[nodiscard]] GuardVeto frame_guard(const GuardInputs& inputs) noexcept;

}  // namespace sc::safety
