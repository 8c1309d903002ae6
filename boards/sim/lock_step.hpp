// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

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

/// What befalls the two sides, for tests of the way on; 0 = nothing.
struct LockStepTroubles {
    std::int64_t kill_host_ns = 0;   ///< SIGKILL to the host's process at this time of the cell, once …
    std::int64_t kill_delay_us = 0;  ///< … this long after the answer has gone out, in real time
    std::int64_t power_off_ns = 0;   ///< the cell stands still from here on: it loses its power
    std::int64_t gap_ns = 0;         ///< that the cell lives alone between two hosts
};

/// The same over a socket that listens at `path` (printed on stderr once it does), for one host after another, until
/// `*stop`. False when the cell has lost its power. Throws std::system_error.
[[nodiscard]] bool serve_lock_step(SimCell& cell, const std::filesystem::path& path, const LockStepTroubles& troubles,
                                   const volatile bool* stop);

}  // namespace sc::sim
