// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/units/time.hpp"

namespace sc::host {

/// A carrier of bytes between the host and one cell, together with the clock that the host must live by: real time on a
/// wire, the cell's virtual time when the cell is simulated in lock-step. Frames, checksums and messages are the
/// client's work. One thread; not copyable.
class Transport {
public:
    Transport() = default;
    Transport(const Transport&) = delete;
    Transport& operator=(const Transport&) = delete;
    virtual ~Transport() = default;

    /// Hands bytes over for sending. Never blocks; bytes for a closed carrier are dropped (`closed` says so).
    virtual void send(std::span<const std::uint8_t> bytes) = 0;
    /// Waits until bytes have arrived or the clock has reached `until`, and returns how many were put into `out` (0 at
    /// the end of the time, when the carrier closed, or when a signal came). This is also when time passes in
    /// lock-step, and when waiting bytes are sent.
    virtual std::size_t receive(std::span<std::uint8_t> out, HostTime until) = 0;
    [[nodiscard]] virtual HostTime now() const = 0;
    /// The other side has gone; it does not come back.
    [[nodiscard]] virtual bool closed() const = 0;
};

}  // namespace sc::host
