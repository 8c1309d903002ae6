// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sc::sim {

/// The most instructions executed in one tick, and which tick it was (the first of equals).
struct InstructionMax {
    std::uint64_t count = 0;
    std::int64_t tick = -1;
};

/// Instructions of the controller's two steps over some ticks; `tick` is the two together.
struct InstructionFigures {
    InstructionMax servo;
    InstructionMax plan;
    InstructionMax tick;
    std::uint64_t servo_total = 0;
    std::uint64_t plan_total = 0;
    std::uint64_t ticks = 0;
};

/// What a board tells of itself at the end of a run.
struct BoardFigures {
    InstructionFigures all;
    InstructionFigures marking;             ///< over the ticks whose outputs are of the state `marking`
    std::uint64_t stack_used_at_start = 0;  ///< bytes, until the first tick
    std::uint64_t stack_used = 0;           ///< bytes, at most in any tick so far
    std::uint64_t stack_size = 0;
    std::uint64_t controller_bytes = 0;
};

}  // namespace sc::sim
