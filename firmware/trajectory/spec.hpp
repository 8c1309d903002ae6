// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <expected>

#include "shared/machine/machine.hpp"

/// What a path may do, and what is wrong with one. Base units: metres, degrees for C, seconds.

namespace sc::trajectory {

/// X, Y, Z in metres and C in degrees.
using Place = std::array<double, kAxisCount>;

/// Per-axis limits. An axis of which all three are zero must not move.
struct AxisLimits {
    Place speed{};
    Place acceleration{};
    Place jerk{};
};

struct Spec {
    double speed = 0.0;      ///< along x, y, z (m/s), more than 0
    double tolerance = 0.0;  ///< greatest distance from the polyline (m); below 0.1 µm every corner is a stop
    AxisLimits limits;
};

enum class Problem : std::uint8_t {
    bad_speed,      ///< path speed not in [1e-6, 1e3] m/s
    bad_tolerance,  ///< not in [0, 1] m
    bad_limit,      ///< of `axis`: not in [1e-6, 1e9], or only some of an axis' three are zero
    bad_point,      ///< `axis` of `point` is not finite or beyond ±1e4
    blocked_axis,   ///< `point` moves `axis`, whose limits are zero
    no_room,        ///< `point` came while wants_points() was false
    too_short,      ///< the path ended with fewer than two distinct points; `point` is their number
    not_open,       ///< no path is open
    bad_arc,        ///< the arc to `point`: no circle through its places, or a radius of more than kWidestArc
    no_arc_here,    ///< the arc to `point` has no point before it, or the tolerance is below kLeastArcTolerance
};

/// Why something was not accepted; nothing was changed by it.
struct Refusal {
    Problem problem = Problem::not_open;
    std::uint32_t point = 0;  ///< number of the point since open(), from 0
    std::uint8_t axis = 0;    ///< index into a Place
};

/// The limits as the planner uses them: C is measured in metres, such that its greatest speed is the path speed, so
/// that one length, one tolerance and one speed hold for all axes. Lengths that follow from the limits are worked out
/// once.
struct Limits {
    double speed = 0.0;
    double tolerance = 0.0;
    Place velocity{};
    Place acceleration{};
    Place jerk{};
    double metres_per_turn_unit = 0.0;  ///< of C; 0 if it must not move
    double merge = 0.0;                 ///< points closer than this to the last kept one are merged
    double corner_cosine = 0.0;         ///< a vertex that turns by more is a corner
    double longest_cell = 0.0;          ///< between knots where the path bends
    double longest_step = 0.0;          ///< of the timing, there
    double stub = 0.0;                  ///< a straight piece at a corner longer than this is of no more use
    double window = 0.0;                ///< length that a plan looks ahead
    double near_rest = 0.0;             ///< length before a plan's rest that the next plan makes anew

    [[nodiscard]] Place scaled(const Place& place) const noexcept {
        return {place[0], place[1], place[2], place[3] * metres_per_turn_unit};
    }
    [[nodiscard]] double unscale(std::size_t axis) const noexcept {
        return axis == 3 && metres_per_turn_unit > 0.0 ? 1.0 / metres_per_turn_unit : 1.0;
    }
};

[[nodiscard]] std::expected<Limits, Refusal> make_limits(const Spec& spec) noexcept;

}  // namespace sc::trajectory
