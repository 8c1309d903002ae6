// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "shared/link/can_framing.hpp"

namespace sc::sim {

/// Bits of one CAN frame on the wire, from its start to the end of the interframe space (ISO 11898-1:2015).
struct FrameBits {
    int nominal = 0;  ///< at the arbitration's rate
    int data = 0;     ///< at the data phase's rate; 0 for a classic frame
};

/// With 11-bit identifier; stuff bits as this frame's identifier, data and (classic) CRC need them. FD frames switch
/// their rate, and have a stuff count and a CRC of 17 bits (up to 16 bytes) or 21 with fixed stuff bits.
[[nodiscard]] FrameBits frame_bits(const link::LinkCanFrame& frame) noexcept;

struct CanRates {
    std::uint32_t nominal = 1'000'000;
    std::uint32_t data = 5'000'000;
};
/// Time of the frame on the wire, rounded up.
[[nodiscard]] std::int64_t frame_ns(const link::LinkCanFrame& frame, const CanRates& rates) noexcept;

}  // namespace sc::sim
