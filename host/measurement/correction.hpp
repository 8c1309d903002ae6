// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/formats/station_job.hpp"
#include "host/measurement/station.hpp"

/// What to turn, and by how much, until a workpiece sits as its target says.

namespace sc::host {

/// Within the tolerance, out of it, or nearer to its border than the measurement (95 %) can tell.
enum class Verdict : std::uint8_t { good, adjust, too_near_to_tell };

struct ScrewTurn {
    std::string id;
    double travel = 0.0;  ///< metres; positive moves the face towards the head
    double turns = 0.0;   ///< clockwise positive
};

/// Applied in this order about the pivot (where the distance is taken), the workpiece then sits on its target: first
/// turn about z of r, then about y of r turned by the target's yaw, then shift along x of r. Right-handed, radians and
/// metres.
struct Correction {
    double turn_z = 0.0;
    double turn_y = 0.0;
    double shift_x = 0.0;
    double off_angle = 0.0;  ///< between measured and target normal, 0 or more
    std::vector<ScrewTurn> screws;
    std::optional<Verdict> verdict;  ///< where tolerances are given
};

/// Unit normal in r, towards the head, of a plane with this angle to the reference and this yaw.
[[nodiscard]] Vec3 normal_of(double angle, double yaw) noexcept;

/// Angle, yaw and distance of the batch's median, each by itself; `results` is not empty.
[[nodiscard]] StationTarget median_target(std::span<const StationResult> results);

/// `job` with screws and tolerances; `target` with figures (its `same` is not looked at).
[[nodiscard]] Correction correction_of(const StationResult& result, const StationTarget& target, const StationJob& job);

/// "turn 0.35 deg about z, ...", for a person.
[[nodiscard]] std::string correction_text(const Correction& correction);

}  // namespace sc::host
