// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/controller/controller.hpp"

namespace sc::mps2_an500 {

/// Serves the PC's requests through the shared RAM for ever, with `outputs` as memory. Interrupts off.
[[noreturn]] void serve_lock_step(Controller& controller, ServoOutputs& outputs) noexcept;

}  // namespace sc::mps2_an500
