// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

namespace sc::host {

struct Circle {
    double x = 0.0;
    double y = 0.0;
    double radius = 0.0;
    double residual = 0.0;  ///< rms distance of the points that count from the circle
    std::size_t used = 0;   ///< points that count
};

/// Circle of least squares: the algebraic solution (the paper's equations 15 to 18) starts, Gauss and Newton on the
/// distances finish; points further off than three robust standard deviations are then left out, and so on until none
/// is. nullopt for fewer than five points, or points on a line.
[[nodiscard]] std::optional<Circle> fit_circle(std::span<const std::array<double, 2>> points);

}  // namespace sc::host
