// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sc::sim {

/// What real drives do differently. Nothing by default.
struct DriveQuirks {
    std::int64_t pdo_gap_ns = 0;       ///< an RPDO that comes sooner after the last is not taken
    std::int64_t pdo_delay_ns = 0;     ///< from the SYNC to an RPDO's effect
    std::uint32_t period_step_us = 0;  ///< 1006 and 60C2 in steps of this only, up to 20 ms
    std::uint32_t lost_syncs = 0;      ///< so many SYNCs missed in a row are a fault (8700)
    bool no_period = false;            ///< 60C2 is 0, 0 after a reset
    bool no_6007 = false;              ///< and no 1006
    bool event_driven = false;         ///< its PDOs are on after a reset, and go when something changes
    bool bit_30 = false;               ///< COB-IDs of TPDOs must keep bit 30 (no remote request)
    bool no_dummy = false;             ///< 0007 cannot be mapped
    bool operator==(const DriveQuirks&) const = default;
};

/// By name, several with commas between; "" is none. lenze-931e, lenze-9400, infranor, delta: as those drives are said
/// to be; no-period, no-6007, event-driven, bit-30, no-dummy: one thing each. Throws std::invalid_argument with the
/// names for any other.
[[nodiscard]] DriveQuirks drive_quirks(std::string_view names);
[[nodiscard]] std::vector<std::string> drive_quirk_names();

}  // namespace sc::sim
