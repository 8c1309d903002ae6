// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/motion/profile.hpp"
#include "shared/codes/codes.hpp"
#include "shared/machine/machine.hpp"

/// Geometry of a path: straight lines, and blends that round a corner within the tolerance.
///
/// A path is measured by its parameter tau, which is true length on lines. A blend of length 2h about a corner has the
/// derivative d1 + (d2 − d1) w(u) with u = tau / 2h and w = 3u² − 2u³: it takes exactly h from both lines, its second
/// derivative starts and ends at zero, and it leaves the corner by 3/16 · h · |d2 − d1| at most (at its middle; w
/// integrates to 3/32 of 2h there). Blends are passed at constant speed, so with q'' ≤ 1.5 |Δd| / 2h and q''' ≤ 6 |Δd|
/// / (2h)² per axis the speed that keeps each axis' acceleration and jerk follows in closed form. Lines take all
/// changes of speed.

namespace sc::motion {

/// X, Y, Z in metres and C in degrees; for galvo paths x and z relative to the field's centre.
using Place = std::array<double, kAxisCount>;

/// Per-axis limits in base units. Axes that a path does not move may be zero.
struct AxisLimits {
    std::array<double, kAxisCount> speed{};
    std::array<double, kAxisCount> acceleration{};
    std::array<double, kAxisCount> jerk{};
};

struct Element {
    enum class Kind : std::uint8_t { line, blend };
    Kind kind = Kind::line;
    bool stop_at_end = false;  ///< a corner that cannot be rounded within the tolerance
    LimitedBy limited = LimitedBy::path_speed;
    std::uint32_t item = 0;  ///< the point item at or before its start
    double start = 0.0;      ///< tau at its start
    double length = 0.0;     ///< in tau
    double distance = 0.0;   ///< true path length at its start
    double true_length = 0.0;
    double cap = 0.0;      ///< highest speed (d tau / dt)
    TangentLimits limits;  ///< lines only
    Place origin{};
    Place d1{};            ///< direction at its start: unit length over x, y, z (or ±1 in C alone)
    Place bend{};          ///< blends: direction at the end less that at the start
    double cubic = 0.0;    ///< blends: 1 / length²
    double quartic = 0.0;  ///< blends: 1 / (2 length³)
    /// True length from the middle, odd in the way z from there: Σ odd[i] z^(2i+1). See make_blend.
    std::array<double, 4> odd{1.0, 0.0, 0.0, 0.0};

    [[nodiscard]] double end() const noexcept { return start + length; }

    // In the way t = tau − start, 0 ≤ t ≤ length: polynomials, no division, no root. For the frames and pulses.

    /// How far the bend has set in: place = origin + d1 · t + bend · bent(t).
    [[nodiscard]] double bent(double t) const noexcept { return t * t * t * (cubic - quartic * t); }
    [[nodiscard]] double axis(std::size_t i, double t, double bent_so_far) const noexcept {
        return origin[i] + (d1[i] * t + bend[i] * bent_so_far);
    }
    /// True length from the element's start. On a line, t but for rounding.
    [[nodiscard]] double length_to(double t) const noexcept {
        const double z = t - 0.5 * length;
        const double q = z * z;
        return 0.5 * true_length + z * (odd[0] + q * (odd[1] + q * (odd[2] + q * odd[3])));
    }
    /// d(true length)/dt: 1 on lines, less within a blend.
    [[nodiscard]] double stretch(double t) const noexcept {
        const double z = t - 0.5 * length;
        const double q = z * z;
        return odd[0] + q * (3.0 * odd[1] + q * (5.0 * odd[2] + q * (7.0 * odd[3])));
    }

    /// Place at tau, start ≤ tau ≤ end.
    [[nodiscard]] Place place(double tau) const noexcept;
    /// True path length from the path's start at tau.
    [[nodiscard]] double distance_at(double tau) const noexcept;
};

/// Line from `from` along unit `direction`; fills cap and tangential limits from the axes'. Cost: some 100 operations.
[[nodiscard]] Element make_line(const Place& from, const Place& direction, double length, double speed,
                                const AxisLimits& axes) noexcept;
/// Blend that starts at `from` with direction d1 and ends with d2, both unit. `half` is h.
///
/// |q'|² = 1 − |Δd|² w (1 − w) has no closed integral. The true length is taken from an odd polynomial about the middle
/// that agrees in length (Gauss-Legendre, 1e-12) and its first two derivatives at the ends, and in the first at the
/// middle. It is within 4e-4 of the blend's length and 0.3 % of the stretch up to 90°, three times that at 120°.
[[nodiscard]] Element make_blend(const Place& from, const Place& d1, const Place& d2, double half, double speed,
                                 const AxisLimits& axes) noexcept;

}  // namespace sc::motion
