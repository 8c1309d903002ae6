// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <variant>

#include "shared/units/quantity.hpp"

/// What a job is made of once the host has converted everything: a sequence of items, numbered from 0. The number is
/// the stream's sequence number: an item is accepted exactly once, in order, whatever the carrier does.
///
///     Turn, then for each line: PathBegin, PathPoint, then PathPoint or PathArc × n, PathEnd; at last
///     JobEnd.
///
/// Where the Y sensor watches the surface, Looks come before the lines that they are for, at the same angle of C.
///
/// A path may be dark between two of its points: PathLight{false} behind the point where the light ends,
/// PathLight{true} behind that where it begins again. Of a split path the items before a point also say where the stage
/// is when the path gets there: StageCurve behind PathBegin, then StageKnot, each before the point that needs it
/// (stage_curve.hpp).
///
/// The controller makes the dark moves itself: retract before a turn, the way to the start of a path, the run-in.

namespace sc {

/// Unit of a coordinate on the wire: 10 nm. A 32-bit coordinate spans ±21 m.
inline constexpr double kWireUnitsPerMetre = 1e8;
inline constexpr std::int64_t kPmPerWireUnit = 10'000;
/// Unit of an angle of C on the wire: 1e-5 degree.
inline constexpr double kWireUnitsPerDegree = 1e5;
inline constexpr std::int64_t kNdegPerWireUnit = 10'000;

/// Who moves the beam along a path.
enum class Actuator : std::uint8_t {
    axes = 0,   ///< X, Y, Z follow the path, the galvo stays at zero
    galvo = 1,  ///< X, Y, Z stand at the anchor, the mirrors follow the path (a fixed field)
    split = 2,  ///< X, Y, Z follow a smooth curve of their own over path distance, the mirrors take the rest
};

struct PathBegin {
    std::uint32_t path = 0;  ///< id, unique in the job
    Actuator actuator = Actuator::axes;
    std::uint8_t pass = 0;           ///< number of this pass over the same line; the host repeats the items for each
    std::uint32_t speed_um_s = 0;    ///< path speed
    std::uint32_t pitch_nm = 0;      ///< distance between pulses along the path
    std::uint32_t energy_nj = 0;     ///< of one pulse
    std::uint32_t tolerance_nm = 0;  ///< how far the beam may leave the polyline at corners
    std::int32_t anchor_x = 0;       ///< wire units; galvo paths only
    std::int32_t anchor_y = 0;
    std::int32_t anchor_z = 0;
    constexpr bool operator==(const PathBegin&) const noexcept = default;
};
/// A place in h at the present angle of C, wire units.
struct PathPoint {
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t z = 0;
    constexpr bool operator==(const PathPoint&) const noexcept = default;
};
/// From the last place over `via` to `to` on a circle. The path stays within the tolerance of the true arc. A whole
/// circle is two of them.
struct PathArc {
    PathPoint via;
    PathPoint to;
    constexpr bool operator==(const PathArc&) const noexcept = default;
};
/// From the last point on the path is marked, or passed dark. A path begins and ends marked. Each marked stretch has
/// its pulses at whole pitches from its own beginning; their numbers go on.
struct PathLight {
    bool on = false;
    constexpr bool operator==(const PathLight&) const noexcept = default;
};
/// Distance along the path between knots of the stage's curve.
struct StageCurve {
    std::uint32_t spacing_um = 0;
    constexpr bool operator==(const StageCurve&) const noexcept = default;
};
/// The next control point of the stage's curve: a place in h, wire units.
struct StageKnot {
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t z = 0;
    constexpr bool operator==(const StageKnot&) const noexcept = default;
};
struct PathEnd {
    constexpr bool operator==(const PathEnd&) const noexcept = default;
};
/// Retract y, turn C to this angle (wire units), wait until it stands.
struct Turn {
    std::int32_t c = 0;
    constexpr bool operator==(const Turn&) const noexcept = default;
};
/// The Y sensor looks at a line before it is burnt: the axes go, dark and straight, to this place of theirs in h (wire
/// units), at which the sensor sees the surface of the line and reads its zero.
struct Look {
    std::uint32_t speed_um_s = 0;  ///< 0: a look begins there; else it goes on to there at this speed
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t z = 0;
    constexpr bool operator==(const Look&) const noexcept = default;
};
/// Retract y and end the job.
struct JobEnd {
    constexpr bool operator==(const JobEnd&) const noexcept = default;
};

using Item = std::variant<PathPoint, PathBegin, PathEnd, Turn, JobEnd, PathArc, PathLight, StageCurve, StageKnot, Look>;

/// How far a job has come, as the laser knows it. Pulse numbers restart at 0 in each pass of a path.
struct FiredPosition {
    std::uint32_t path = 0;
    std::uint8_t pass = 0;
    std::uint32_t item = 0;    ///< index of the point before the last pulse
    std::uint32_t pulses = 0;  ///< pulses fired in this pass
    constexpr bool operator==(const FiredPosition&) const noexcept = default;
};

}  // namespace sc
