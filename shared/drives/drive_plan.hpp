// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "shared/machine/machine.hpp"

/// How the drives are spoken to: what of CANopen each of them can do, chosen from its data sheet (EDS) on the host and
/// handed to the controller by its board. A plan that says nothing suits a drive that has all objects.

namespace sc {

inline constexpr std::size_t kDriveBuses = 2;

/// Objects of the set-up that a drive may lack, as bits of DriveOptions::absent.
namespace drive_object {
inline constexpr std::uint16_t k6007 = 0x0001;   ///< what it does on a lost connection
inline constexpr std::uint16_t k1006 = 0x0002;   ///< time between two SYNCs
inline constexpr std::uint16_t k6065 = 0x0004;   ///< following-error window
inline constexpr std::uint16_t k6066 = 0x0008;   ///< and its time
inline constexpr std::uint16_t k6085 = 0x0010;   ///< ramp of a quick stop
inline constexpr std::uint16_t k609A = 0x0020;   ///< acceleration of a homing
inline constexpr std::uint16_t kRpdos = 0x0040;  ///< further RPDOs, 1401 to 1403
inline constexpr std::uint16_t kTpdos = 0x0080;  ///< further TPDOs, 1801 to 1803
inline constexpr std::uint16_t kAll = 0x00FF;
}  // namespace drive_object

/// Homing by CiA 402's number of the method; −1 to −4 are makers' numbers for a hard stop.
inline constexpr std::int8_t kHomeSwitchMethod = 19;

struct DriveOptions {
    std::uint8_t bus = 0;           ///< 0 or 1
    std::uint8_t status_every = 1;  ///< its status comes with every n-th SYNC, 1 to 16
    /// Its target travels with another drive's in one RPDO, its controlword by itself and on a change only. Drives of a
    /// bus are paired in the order of the axes.
    bool paired = false;
    std::int8_t homing_method = kHomeSwitchMethod;  ///< 6098
    std::uint16_t absent = 0;                       ///< drive_object bits: not there, not sent
    /// The brake of an axis that would fall: the target moves only so long after the drive is enabled, and the drive is
    /// disabled only so long after the brake was told to close (60FE:1 bit 0). 0: no such brake, or the drive's own
    /// affair.
    std::uint16_t brake_release_ms = 0;
    std::uint16_t brake_apply_ms = 0;
    std::uint32_t vendor = 0;   ///< 1018:1 that it must show; 0: any
    std::uint32_t product = 0;  ///< 1018:2
    constexpr bool operator==(const DriveOptions&) const noexcept = default;
};

struct DrivePlan {
    std::array<DriveOptions, kAxisCount> drive{};
    constexpr bool operator==(const DrivePlan&) const noexcept = default;
};
inline constexpr DrivePlan kPlainDrives{};
/// Of the drive whose status comes least often.
[[nodiscard]] constexpr std::uint32_t most_status_every(const DrivePlan& plan) noexcept {
    std::uint32_t most = 1;
    for (const DriveOptions& drive : plan.drive) {
        most = drive.status_every > most ? drive.status_every : most;
    }
    return most;
}

/// The place of an axis' target in a common RPDO.
struct TargetPair {
    std::uint8_t first = 0;   ///< axis whose identifier the RPDO has
    std::uint8_t second = 0;  ///< the other; the same as `first` where there is none
    constexpr bool operator==(const TargetPair&) const noexcept = default;
};
/// For a paired drive. O(axes).
[[nodiscard]] TargetPair target_pair(const DrivePlan& plan, std::size_t axis) noexcept;

}  // namespace sc
