// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

/// Frames and counts of a CAN port, in the shape that boards/socketcan has on Linux.

namespace sc::stm32h743 {

struct CanFrame {
    std::uint32_t id = 0;  ///< 11 bits, 29 when `extended`
    bool extended = false;
    bool remote = false;  ///< classic only; carries no data
    bool fd = false;
    bool fast = false;      ///< FD: with the rate of the data phase (BRS)
    std::uint8_t size = 0;  ///< bytes; classic 0..8, FD 0..8, 12, 16, 20, 24, 32, 48, 64
    std::array<std::uint8_t, 64> data{};
    /// Received on a classic port: bit times from its start to when it was fetched, modulo 65 536.
    std::uint16_t age_bits = 0;
    bool operator==(const CanFrame&) const noexcept = default;
};

enum class CanSent : std::uint8_t {
    yes,
    full,    ///< no room in the queue of the controller; try again later
    down,    ///< not started, or bus-off
    failed,  ///< no frame of this port: wrong size or identifier, FD on a classic port
};

enum class BusState : std::uint8_t {
    active,
    warning,  ///< an error counter is at 96 or above
    passive,  ///< above 127
    bus_off,  ///< until Fdcan::service starts it again
    down,     ///< not started
};

struct CanCounters {
    std::uint32_t sent = 0;      ///< taken into the controller's queue
    std::uint32_t received = 0;  ///< handed over
    std::uint32_t full = 0;
    std::uint32_t down = 0;
    std::uint32_t failed = 0;
    std::uint32_t lost = 0;       ///< times the receive queue was found to have overflowed; a frame or more each
    std::uint32_t abandoned = 0;  ///< frames dropped from the queue at a restart after bus-off
    std::uint32_t errors = 0;     ///< errors on the bus; up to 255 between two calls of service, then at least so many
    std::uint32_t no_acks = 0;    ///< calls of service that found: sent last, and nobody heard
    std::uint32_t bus_offs = 0;
    std::uint32_t restarts = 0;
    std::uint8_t tx_error_count = 0;  ///< as service found it
    std::uint8_t rx_error_count = 0;
};

}  // namespace sc::stm32h743
