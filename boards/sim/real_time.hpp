// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/port/port.hpp"
#include "boards/sim/cell.hpp"

namespace sc::sim {

/// Runs a cell at `speed` seconds of its time a second, with the host on `port`, until `*stop` is true. When the
/// machine was asleep or too slow by more than 0.2 s, the cell's time is let slip (and a warning logged), never rushed.
void serve_real_time(SimCell& cell, port::Port& port, double speed, const volatile bool* stop);

}  // namespace sc::sim
