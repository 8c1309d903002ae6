// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/controller/controller.hpp"

namespace sc::mps2_an500 {

/// Runs the controller by the board's own clock for ever, its link on UART0 at 115200 baud. Nothing else is wired to
/// this board: all its digital inputs read as a broken wire, no drive answers, and outputs other than the link's go
/// nowhere. So the controller stays in `boot` or `fault`, and answers.
[[noreturn]] void run_free(Controller& controller, ServoOutputs& outputs, std::int64_t period_ns) noexcept;

}  // namespace sc::mps2_an500
