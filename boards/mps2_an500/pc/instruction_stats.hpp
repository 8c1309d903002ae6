// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "boards/sim/board_figures.hpp"

namespace sc::mps2_an500 {

/// What one tick cost, in executed instructions of the core. Packing and unpacking are not in it.
struct TickCost {
    std::uint32_t servo = 0;
    std::uint32_t plan = 0;
};

/// Adds a tick to the figures of a board.
void add(sim::InstructionFigures& figures, const TickCost& cost, std::int64_t tick);

}  // namespace sc::mps2_an500
