// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "host/path/job_plan.hpp"
#include "host/path/profile.hpp"

/// What the machine must be able to do for one path. Each check throws InputError.

namespace sc::host {

/// Limits along a direction (unit, in h): of the slowest axis or mirror that moves.
[[nodiscard]] MoveLimits limits_along(const Vec3& direction, Actuator actuator, const MachineConfig& machine);

/// Length of the dark stretch kept free before and after a path. More than the distance that the speed needs, so that
/// the controller's own run-in always fits: a quarter more, and 0.5 mm (axes) or 0.1 mm (galvo) for latencies.
[[nodiscard]] double run_in_length(const Vec3& direction, const MarkSettings& settings, const MachineConfig& machine);

/// Speed, pitch, rate and energy against actuator and laser. Returns the smallest whole number of source periods a
/// pulse for which the source runs within its range.
[[nodiscard]] std::uint8_t check_settings(const PlannedPath& path, const Job& job, const MachineConfig& machine);

/// The depth of a galvo path about its anchor against the window of its fluence tolerance.
void check_depth(const PlannedPath& path, const BeamRecord& beam);

/// Places, extreme points of arcs and ends with run-in, and the anchor of a galvo path, against travel, field and
/// keep-out volumes. `compensation` moves set-points a little off the places; the set-points are what must fit.
void check_places(const PlannedPath& path, const MachineConfig& machine, const Compensation& compensation);

/// Places of the axes between which the Y sensor looks at the path, against travel and keep-out volumes.
void check_look(const PlannedPath& path, const Vec3& from, const Vec3& to, const MachineConfig& machine,
                const Compensation& compensation);

/// Whether the straight way between two places meets the box (touching counts). A few comparisons.
[[nodiscard]] bool meets(const KeepOut& box, const Vec3& from, const Vec3& to) noexcept;

}  // namespace sc::host
