// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/sim/cell.hpp"

namespace sc::sim {

/// Serves a cell to one host in lock-step with virtual time, over a stream socket that stays the caller's:
///
///     request  u32 n, i64 run_until_ns, n − 8 bytes for the cell
///     answer   u32 n, i64 now_ns,       n − 8 bytes from the cell
///
/// all little-endian. The cell ticks until `run_until_ns`, or to the end of the tick in which its first byte for the
/// host came out of the wire. Returns when the host has closed its end, has sent a frame that is none (n below 8 or
/// above 16 MiB), or `*stop` has become true.
void serve_lock_step(SimCell& cell, int socket, const volatile bool* stop);

}  // namespace sc::sim
