// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "host/formats/cameras.hpp"
#include "shared/geometry/vec.hpp"

/// What a camera sees of a place, and the ray of a pixel. D. C. Brown, "Close-range camera calibration",
/// Photogrammetric Engineering 37 (1971); the formulas stand at CameraModel.

namespace sc::host {

using Pixel = std::array<double, 2>;

/// Where a place of the camera frame (any unit) is seen; none for what is not in front of the camera.
[[nodiscard]] std::optional<Pixel> project(const CameraModel& camera, const Vec3& place);

struct Projection {
    Pixel at{};
    std::array<std::array<double, 3>, 2> by_place{};                          ///< px per unit of the place
    std::array<std::array<double, CameraModel::kParameters>, 2> by_camera{};  ///< in the order of kCameraParameters
};
/// The same with analytic derivatives.
[[nodiscard]] std::optional<Projection> project_with_slopes(const CameraModel& camera, const Vec3& place);

struct Ray {
    double x = 0.0;                                   ///< X/Z
    double y = 0.0;                                   ///< Y/Z
    double residual = 0.0;                            ///< px: how far its projection is from the pixel
    std::array<std::array<double, 2>, 2> by_pixel{};  ///< d(x, y)/d(u, v)
};
/// The ray of a pixel by Newton's method to 1e-9 px; none where the model folds over or does not reach the pixel.
[[nodiscard]] std::optional<Ray> undistorted(const CameraModel& camera, const Pixel& at);

}  // namespace sc::host
