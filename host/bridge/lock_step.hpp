// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/units/time.hpp"

namespace sc::host {

/// The lock-step conversation with a cell in virtual time, over a stream socket:
///
///     request  u32 n, i64 run_until_ns, n − 8 bytes for the cell
///     answer   u32 n, i64 now_ns,       n − 8 bytes from the cell
///
/// all little-endian. The cell runs from its time to `run_until_ns`, or less, and says how far it came. Virtual time
/// passes only within an exchange, so however slow the host is, the cell does not starve.
class LockStep {
public:
    /// `socket` stays the caller's.
    explicit LockStep(int socket) noexcept : socket_(socket) {}

    /// One exchange. Appends the cell's bytes to `received`. False when the cell has closed its end, has sent a frame
    /// that is none, has gone back in time, or is silent for 30 s of real time; then nothing more can be exchanged.
    [[nodiscard]] bool exchange(std::span<const std::uint8_t> bytes, Nanoseconds run_until,
                                std::vector<std::uint8_t>& received);
    /// The cell's virtual time after the last exchange.
    [[nodiscard]] HostTime now() const noexcept { return now_; }

private:
    int socket_;
    HostTime now_{};
};

}  // namespace sc::host
