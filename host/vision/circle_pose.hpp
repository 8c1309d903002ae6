// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <expected>
#include <span>
#include <string>

#include "host/vision/ellipse.hpp"
#include "shared/geometry/vec.hpp"

/// What the ellipse of a circle says of the circle. The middle of the ellipse is not where the circle's middle is seen:
/// 0.1 px and more off for a circle of 20 px at 45°. Camera frame: x right, y down, z along the view; a camera without
/// distortion.

namespace sc::host {

struct Pinhole {
    double focal_x = 0.0;  ///< px
    double focal_y = 0.0;  ///< px
    double middle_x = 0.0;
    double middle_y = 0.0;
};

/// The two unit normals, towards the camera, that a circle of this ellipse may have (axes of the cone of rays).
[[nodiscard]] std::array<Vec3, 2> circle_normals(const Ellipse& ellipse, const Pinhole& camera);

/// The one normal that circles on one plane agree on: the second solution differs from circle to circle by twice the
/// angle between their rays. Refused, with the reason, for fewer than two circles, circles that do not agree to 5°, and
/// circles too near to each other, or too nearly square to the view, to tell the solutions apart where that matters.
[[nodiscard]] std::expected<Vec3, std::string> common_normal(std::span<const Ellipse> ellipses, const Pinhole& camera);

/// Where the circle's middle is seen, px: the pole of the plane's vanishing line, C*·Kᵀ⁻¹·n.
[[nodiscard]] std::array<double, 2> circle_centre(const Ellipse& ellipse, const Pinhole& camera, const Vec3& normal);

/// The circle's middle in the camera frame, in the unit of `radius`.
[[nodiscard]] Vec3 circle_place(const Ellipse& ellipse, const Pinhole& camera, const Vec3& normal, double radius);

}  // namespace sc::host
