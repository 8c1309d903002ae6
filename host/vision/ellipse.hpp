// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace sc::host {

/// An ellipse in a picture; pixels, (0, 0) is the middle of the first pixel, y down.
struct Ellipse {
    double x = 0.0;
    double y = 0.0;
    double major = 0.0;  ///< semi-axis, major ≥ minor
    double minor = 0.0;  ///< semi-axis
    double angle = 0.0;  ///< rad, of the major axis from +x towards +y, in (−π/2, π/2]
};

/// Shape S of an ellipse, the symmetric matrix [xx, xy, yy]: a line with unit normal n is a tangent where its distance
/// from the centre is √(nᵀ·S·n). The dual conic is [S − c·cᵀ, −c; −cᵀ, −1].
using EllipseShape = std::array<double, 3>;

}  // namespace sc::host
