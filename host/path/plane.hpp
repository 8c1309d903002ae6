// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "shared/geometry/vec.hpp"

namespace sc::host {

/// The plane y = centroid.y + slope_x·(x − centroid.x) + slope_z·(z − centroid.z): the depth of a face across the beam.
struct FacePlane {
    Vec3 centroid;  ///< metres
    double slope_x = 0.0;
    double slope_z = 0.0;
    double rms = 0.0;  ///< of the points about it, metres

    [[nodiscard]] double depth(double x, double z) const noexcept {
        return centroid.y + slope_x * (x - centroid.x) + slope_z * (z - centroid.z);
    }
};

/// Least squares through the points (at least one). A slope that the points cannot show is 0: one point gives the plane
/// across the beam, points on a line slope along that line alone.
[[nodiscard]] FacePlane fit_plane(std::span<const Vec3> points);

}  // namespace sc::host
