// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>

#include "shared/drives/bus_budget.hpp"

/// The sum of bus_budget.hpp term by term, for whoever has to show it, and for other numbers of axes.

namespace sc::drives {

/// What is to share one drive bus.
struct BusPlan {
    std::uint32_t axes = kAxisCount;
    std::uint32_t bitrate = kDriveBusBitrate;  ///< bits / s
    std::int64_t cycle_ns = 2'000'000;         ///< one SYNC
    std::int64_t heartbeat_ns = kHeartbeatPeriodNs;
    std::int64_t service_ns = 0;  ///< one SDO pair, one EMCY and one controlword in so long; 0: in each cycle
    std::uint32_t status_every = 1;
    std::uint32_t rpdo_bytes = 6;
    std::uint32_t tpdo_bytes = 6;
    bool paired = false;  ///< one RPDO of 8 bytes for the targets of two axes
};

enum class BusFrame : std::uint8_t { sync, target, pair_of_targets, status, controlword, sdo, emergency, heartbeat };

/// Frames of one kind.
struct BusTerm {
    BusFrame frame = BusFrame::sync;
    bool cyclic = true;       ///< false: of the reserve
    std::uint32_t count = 0;  ///< in a period
    std::uint32_t bits = 0;   ///< each, at worst
    std::int64_t period_ns = 1;
    [[nodiscard]] double share(std::uint32_t bitrate) const noexcept {
        return static_cast<double>(count * bits) /
               (static_cast<double>(bitrate) * 1e-9 * static_cast<double>(period_ns));
    }
};
struct BusTerms {
    std::array<BusTerm, 16> term{};
    std::size_t size = 0;
    std::uint32_t bitrate = kDriveBusBitrate;
    [[nodiscard]] std::span<const BusTerm> all() const noexcept { return std::span(term).first(size); }
};

/// The terms of a plan whose axes are alike. Refuses with `bad_config` one that has no axis, no rate or no cycle, or
/// frames over 8 bytes. O(1).
[[nodiscard]] std::expected<BusTerms, Refusal> bus_terms(const BusPlan& plan) noexcept;
/// Those of one bus of the machine. A bus without a drive has no terms.
[[nodiscard]] std::expected<BusTerms, Refusal> bus_terms(const MachineConfig& machine, const DrivePlan& plan,
                                                         std::uint8_t bus) noexcept;
[[nodiscard]] BusBudget sum_of(const BusTerms& terms) noexcept;

/// Refuses what `bus_terms` refuses, and with `drive_bus_full` a total above 1.0: a bus that is only just full delivers
/// the SYNC late.
[[nodiscard]] std::expected<BusBudget, Refusal> bus_budget(const BusPlan& plan) noexcept;

}  // namespace sc::drives
