// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/trajectory/spec.hpp"

/// Straight runs from rest to rest in closed form, and the overlap of two runs at a corner.
///
/// At a corner the next run begins T before the last one ends. Where both are on ramps of constant jerk J the place is
/// C − J (T − u)³/6 · d1 + J u³/6 · d2  with u = 0 … T. It is farthest from the legs at u = T/2, by k·sin θ with
/// k = J T³/48 and θ the angle of the turn, and it misses the corner by 2k·sin(θ/2). A short line leaves its ramp
/// before T is over; it is then nearer to the corner than the ramp would be, and the deviation is less.

namespace sc::trajectory {

/// What may be used along one direction.
struct Along {
    double speed = 0.0;
    double acceleration = 0.0;
    double jerk = 0.0;
};
[[nodiscard]] Along limits_along(const Limits& limits, const Place& direction) noexcept;

/// The straight stretch on one side of a corner.
struct Stub {
    Place direction{};        ///< along the path; d(place)/ds, so at most of length 1
    double length = 0.0;      ///< in s
    std::uint32_t point = 0;  ///< number of the point at its other end
    bool whole = false;       ///< that point is a corner too: the run is this line
};

/// How two runs share a corner: both ramps have the jerk `jerk` (along s), and overlap for `duration`, which may be 0.
struct Joint {
    double duration = 0.0;
    double jerk = 0.0;
};
/// `before` ends at the corner and `after` begins there. `room` is what k·sin θ may be at most.
[[nodiscard]] Joint make_joint(const Limits& limits, const Stub& before, const Stub& after, double room) noexcept;

/// Two lines that meet may be moved outward where they do, so that the rounded corner lies on both sides of the true
/// one: `shift` is for the corner, `room` for make_joint. At most a third of the tolerance, less for short lines.
struct Outward {
    Place shift{};
    double room = 0.0;
};
[[nodiscard]] Outward move_corner(const Limits& limits, const Stub& before, const Stub& after) noexcept;

/// One stretch of constant jerk along a line; state at its start.
struct Phase {
    double duration = 0.0;
    double s = 0.0;
    double v = 0.0;
    double a = 0.0;
    double j = 0.0;
};

/// Fastest way over a line from rest to rest. It begins with a ramp of `head` (its own jerk and duration) and ends with
/// one of `tail`; where the line is too short for these ramps it keeps to the lower of the two jerks throughout.
struct LinePlan {
    static constexpr std::uint32_t kCapacity = 9;
    std::array<Phase, kCapacity> phase{};
    std::uint32_t count = 0;
};
[[nodiscard]] LinePlan plan_line(double length, const Along& limits, const Joint& head, const Joint& tail) noexcept;

}  // namespace sc::trajectory
