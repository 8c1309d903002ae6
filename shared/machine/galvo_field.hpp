// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

/// Field correction in three dimensions, as the controller evaluates it. All in metres and plain slopes.
///
/// A ray that passes the focal plane at p leans by slope(p) = slope0 + slope · p · (1 + bend · |p|²), so on a surface
/// that lies `depth` nearer to the head it lands at s = p − depth · slope(p). The correction of a place (s, depth) is
/// thus: solve for p, then look up the command whose beam passes p in focus. That look-up is a bicubic B-spline over a
/// square of p. No numbers here depend on the axes.

namespace sc {

struct GalvoField {
    /// Coefficients along an edge: kSide − 3 cells, and the spline reaches from −half to +half.
    static constexpr std::size_t kSide = 20;
    static constexpr std::size_t kCells = kSide - 3;
    static constexpr std::size_t kNodes = kSide * kSide;
    /// Numbers of it all, in the order in which they pass over the link.
    static constexpr std::size_t kNumbers = 8 + 2 * kNodes;
    /// |depth| stays within, metres: so far the solution by putting p in again is good (depth · slope of 0.1 and less).
    static constexpr double kDepthMost = 10e-3;

    double half = 0.0;                      ///< 0: no correction
    std::array<double, 2> slope0{};         ///< (x, z) per metre of depth
    std::array<double, 4> slope{};          ///< 1/m, row-major
    double bend = 0.0;                      ///< 1/m²
    std::array<double, 2 * kNodes> node{};  ///< command (x, z) of each node; x runs fastest

    [[nodiscard]] constexpr bool empty() const noexcept { return !(half > 0.0); }
    [[nodiscard]] constexpr double number(std::size_t i) const noexcept {
        return i >= 8 ? node[i - 8] : (i == 0 ? half : (i < 3 ? slope0[i - 1] : (i < 7 ? slope[i - 3] : bend)));
    }
    constexpr void set_number(std::size_t i, double value) noexcept {
        if (i >= 8) {
            node[i - 8] = value;
        } else if (i == 0) {
            half = value;
        } else if (i < 3) {
            slope0[i - 1] = value;
        } else if (i < 7) {
            slope[i - 3] = value;
        } else {
            bend = value;
        }
    }
    constexpr bool operator==(const GalvoField&) const noexcept = default;
};

/// Values and first derivatives of the four cubic B-splines that overlap a cell, at u in [0, 1] of it.
struct SplineWeights {
    std::array<double, 4> value{};
    std::array<double, 4> slope{};  ///< per cell
};
[[nodiscard]] constexpr SplineWeights spline_weights(double u) noexcept {
    constexpr double kSixth = 1.0 / 6.0;
    const double w = 1.0 - u;
    const double uu = u * u;
    const double ww = w * w;
    const double first = kSixth * ww * w;
    const double last = kSixth * uu * u;
    const double second = (2.0 / 3.0) - uu * (1.0 - 0.5 * u);
    return {{first, second, 1.0 - first - second - last, last},
            {-0.5 * ww, u * (1.5 * u - 2.0), -(w * (1.5 * w - 2.0)), 0.5 * uu}};
}

/// Everything finite, the square no larger than 400 mm, slopes no steeper than a lens can have, and neighbouring nodes
/// apart as a correction would leave them: a field that fails is a mistake, and dangerous. Some 10 000 operations.
[[nodiscard]] bool sound(const GalvoField& field) noexcept;

}  // namespace sc
