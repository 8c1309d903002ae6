// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/verification/path_deviation.hpp"
#include "host/verification/pulse_checker.hpp"
#include "host/verification/sample_checker.hpp"
#include "shared/geometry/vec.hpp"
#include "shared/machine/machine.hpp"

/// Judges one motion, rest to rest, by its emitted samples alone: X, Y, Z in picometres and C in nanodegrees, one a
/// tick. Shares no code with the planner. `SampleChecker` judges a whole trace of a cell, with its states and mirrors.
///
/// Differences of samples are averages: the first is the mean speed of a tick, the second a mean acceleration over two,
/// the third a mean jerk over three. A motion within its limits therefore never exceeds them here, however it lies
/// between the ticks, and a breach here is a breach. A jerk that lasts less than three ticks shows only in part.

namespace sc::host {

struct AxisLimits {
    double speed = 0.0;  ///< base units (m; degrees for C) / s; all three are positive and finite
    double acceleration = 0.0;
    double jerk = 0.0;
    double travel_min = -1e300;  ///< base units
    double travel_max = 1e300;
    bool operator==(const AxisLimits&) const = default;
};

/// Differences may exceed a limit by this factor, unless told otherwise.
inline constexpr double kMotionAllow = 1.005;

struct MotionLimits {
    std::array<AxisLimits, kAxisCount> axis{};
    std::optional<double> path_speed;  ///< m/s: of the norm over X, Y, Z
    std::vector<KeepOut> keep_out;     ///< of the place X, Y, Z; its boundary is still allowed
    double period = 1e-3;              ///< seconds between samples
    double allow = kMotionAllow;       ///< for speed, acceleration, jerk; at least 1
    std::int64_t first_tick = 0;       ///< of the first sample
    /// A vertex may be passed by this many tolerances (PathTolerance).
    double cover = 1.4142135623730951;
    bool may_return = false;  ///< along the path (PathTolerance)
};

/// The worst of one quantity.
struct Worst {
    double value = 0.0;  ///< base units / sⁿ
    double limit = 0.0;  ///< 0: none
    double ratio = 0.0;  ///< value, less what rounding to the grid can make, to the limit; 0 without a limit
    std::int64_t tick = 0;
};
struct MotionRow {
    std::string name;              ///< "x", "y", "z", "c", "path", "galvo x", "galvo z"
    std::string unit;              ///< "m" or "deg"
    std::array<Worst, 3> worst{};  ///< speed, acceleration, jerk
};

struct MotionReport {
    std::int64_t ticks = 0;
    std::int64_t first_tick = 0;
    double seconds = 0.0;  ///< from the first to the last sample
    double allow = kMotionAllow;
    std::vector<MotionRow> rows;             ///< x, y, z, c, path (norm over X, Y, Z)
    std::optional<PathDeviation> deviation;  ///< if a path was given
    double tolerance = 0.0;                  ///< metres, of the path
    double cover_tolerance = 0.0;
    std::uint64_t violations = 0;  ///< all of them, each tick
    /// Places where a rule is broken: of ticks in a row the worst; the first kKeptViolations places of each rule. From
    /// SampleChecker: the first kKeptViolations ticks.
    std::vector<Violation> first;
    std::optional<PulseFigures> pulses;  ///< if those and the job's items were given
    PulseLimits pulse_limits;
    [[nodiscard]] bool passed() const noexcept { return violations == 0 && (!pulses || pulses->violations == 0); }
    /// Largest ratio to a limit over all rows.
    [[nodiscard]] double max_limit_ratio() const noexcept;
};

/// Checks speed, acceleration, jerk, rest at both ends, travel, keep-out and, if `path` is given (metres, at least two
/// points), the deviation from it both ways within `tolerance` (metres).
///
/// What counts as broken: a difference beyond limit · allow + what rounding each sample to the grid can make (1, 2, 4
/// units for the three differences); a step of more than J T³/6 at either end, which no axis makes that starts or stops
/// there; a sample more than 1 unit beyond travel; a sample or the chord between two more than 1 pm inside a keep-out
/// volume; and all that PathDeviation finds. A motion at rest at its ends is taken to have been there before and after.
///
/// `path[i]` corresponds to no sample; the last sample is to be the path's end: a planner's caller emits the end as a
/// sample of its own. Memory: 4 bytes a sample and that of path_deviation. Cost: linear, some 50 ns a sample without a
/// path. Throws InputError for no samples, samples beyond 1000 m or a million degrees, limits that are not positive and
/// finite, and for a path or tolerance that is none.
[[nodiscard]] MotionReport check_motion(std::span<const AxisPositions> samples, const MotionLimits& limits,
                                        std::span<const Vec3> path = {}, double tolerance = 0.0);

/// The reference cell's limits without travel and keep-out: 0.2 m/s, 5 m/s², 200 m/s³; C 45, 180, 1800 degrees.
[[nodiscard]] MotionLimits default_motion_limits() noexcept;

/// Largest rounding of the first three differences, in units of the grid.
inline constexpr std::array<double, 3> kDifferenceRounding{1.0, 2.0, 4.0};
/// Units of the integer grid in a base unit of an axis.
[[nodiscard]] constexpr double units_per_base(std::size_t axis) noexcept {
    return axis == index(Axis::c) ? kNdegPerDegree : kPmPerMetre;
}

}  // namespace sc::host
