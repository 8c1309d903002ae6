// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <expected>

#include "shared/codes/codes.hpp"
#include "shared/machine/machine.hpp"

namespace sc::drives {

inline constexpr std::uint32_t kDriveBusBitrate = 1'000'000;
/// Heartbeats of the drives and of the master; a fifth of the reference time-out, so that four may be lost.
inline constexpr std::int64_t kHeartbeatPeriodNs = 20'000'000;

/// Bits of a classic frame with an 11-bit identifier at worst stuffing, with the three bits between frames.
[[nodiscard]] constexpr std::uint32_t worst_frame_bits(std::uint32_t data_bytes) noexcept {
    return 47 + 8 * data_bytes + (33 + 8 * data_bytes) / 4;
}

/// What is to share the drive bus.
struct BusPlan {
    std::uint32_t axes = kAxisCount;
    std::uint32_t bitrate = kDriveBusBitrate;  ///< bits / s
    std::int64_t cycle_ns = 2'000'000;         ///< one SYNC, one RPDO and one TPDO an axis
    std::int64_t heartbeat_ns = kHeartbeatPeriodNs;
    std::uint32_t rpdo_bytes = 6;
    std::uint32_t tpdo_bytes = 6;
};

/// Worst-case shares of the bus, 1.0 = full.
struct BusBudget {
    double cyclic = 0.0;   ///< SYNC, RPDOs, TPDOs
    double reserve = 0.0;  ///< heartbeats of all nodes; one SDO pair and one EMCY in every cycle
    [[nodiscard]] constexpr double total() const noexcept { return cyclic + reserve; }
};

/// Refuses with `bad_config` a plan that has no axis, no rate or no cycle, frames over 8 bytes, or a total above 1.0: a
/// bus that is only just full delivers the SYNC late. O(1).
[[nodiscard]] std::expected<BusBudget, Refusal> bus_budget(const BusPlan& plan) noexcept;
/// The plan of the machine's four drives.
[[nodiscard]] std::expected<BusBudget, Refusal> bus_budget(const MachineConfig& machine) noexcept;

}  // namespace sc::drives
