// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace sc::sim {

/// A cell in virtual time with one end of a link.
class LockStepCell {
public:
    LockStepCell() = default;
    LockStepCell(const LockStepCell&) = delete;
    LockStepCell& operator=(const LockStepCell&) = delete;
    virtual ~LockStepCell() = default;

    /// Bytes for the controller, at now().
    virtual void push_link(std::span<const std::uint8_t> bytes) = 0;
    /// Appends the bytes that have come out of the link since the last call; returns how many.
    virtual std::size_t take_link(std::vector<std::uint8_t>& out) = 0;
    /// Lives one control period.
    virtual void tick() = 0;
    /// Start of the next tick.
    [[nodiscard]] virtual std::int64_t now_ns() const = 0;
};

/// Serves a cell to one host in lock-step with virtual time, over a stream socket that stays the caller's:
///
///     request  u32 n, i64 run_until_ns, n − 8 bytes for the cell
///     answer   u32 n, i64 now_ns,       n − 8 bytes from the cell
///
/// all little-endian. The cell ticks until `run_until_ns`, or to the end of the tick in which its first byte for the
/// host came out of the wire. Returns when the host has closed its end, has sent a frame that is none (n below 8 or
/// above 16 MiB), or `*stop` has become true.
void serve_lock_step(LockStepCell& cell, int socket, const volatile bool* stop);

/// What befalls the two sides, for tests of the way on; 0 = nothing.
struct LockStepTroubles {
    std::int64_t kill_host_ns = 0;   ///< SIGKILL to the host's process at this time of the cell, once …
    std::int64_t kill_delay_us = 0;  ///< … this long after the answer has gone out, in real time
    std::int64_t power_off_ns = 0;   ///< the cell stands still from here on: it loses its power
    std::int64_t gap_ns = 0;         ///< that the cell lives alone between two hosts
};

/// The same over a socket that listens at `path` (printed on stderr once it does), for one host after another, until
/// `*stop`. False when the cell has lost its power. Throws std::system_error.
[[nodiscard]] bool serve_lock_step(LockStepCell& cell, const std::filesystem::path& path,
                                   const LockStepTroubles& troubles, const volatile bool* stop);

}  // namespace sc::sim
