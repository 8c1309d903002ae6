// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <expected>

#include "shared/codes/codes.hpp"
#include "shared/drives/drive_plan.hpp"
#include "shared/machine/machine.hpp"

/// What drives take of their bus at worst: CAN with 11-bit identifiers, ISO 11898-1 bit stuffing.

namespace sc::drives {

inline constexpr std::uint32_t kDriveBusBitrate = 1'000'000;
/// Heartbeats of the drives and of the master; a fifth of the reference time-out, so that four may be lost.
inline constexpr std::int64_t kHeartbeatPeriodNs = 20'000'000;
/// Between two SDO requests on a bus whose every tick has a SYNC.
inline constexpr std::uint32_t kServiceTicks = 4;

/// Bytes of an RPDO (6040 + 607A) and of a TPDO (6041 + 6064).
inline constexpr std::uint32_t kPdoBytes = 6;
inline constexpr std::uint32_t kMostStatusEvery = 16;

/// Bits of a classic frame with an 11-bit identifier at worst stuffing, with the three bits between frames.
[[nodiscard]] constexpr std::uint32_t worst_frame_bits(std::uint32_t data_bytes) noexcept {
    return 47 + 8 * data_bytes + (33 + 8 * data_bytes) / 4;
}

/// Worst-case shares of the bus, 1.0 = full.
struct BusBudget {
    double cyclic = 0.0;   ///< SYNC, RPDOs, TPDOs
    double reserve = 0.0;  ///< heartbeats of all nodes; SDO, EMCY and controlwords by themselves
    [[nodiscard]] constexpr double total() const noexcept { return cyclic + reserve; }
};

/// Of the fuller bus of the machine: `drive_bus_full` for a total above 1.0, since a bus that is only just full
/// delivers the SYNC late; `bad_config` for no cycle, a bus that is none, or a status that comes too rarely. O(axes).
[[nodiscard]] std::expected<BusBudget, Refusal> bus_budget(const MachineConfig& machine,
                                                           const DrivePlan& plan = kPlainDrives) noexcept;

}  // namespace sc::drives
