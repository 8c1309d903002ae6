// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <expected>
#include <string>

#include "host/formats/cameras.hpp"
#include "host/vision/camera.hpp"

/// Places from a calibrated pair of cameras. The frame c is the left camera's: x right, y down, z along the view,
/// metres.

namespace sc::host {

/// Where a place is seen, and how well: xx, xy, yy, px².
struct SeenPoint {
    Pixel at{};
    std::array<double, 3> covariance{1.0, 0.0, 1.0};
};

using PlaceCovariance = std::array<std::array<double, 3>, 3>;  ///< m²

struct Triangulated {
    Vec3 place;                     ///< in c
    PlaceCovariance noise{};        ///< by the pixels
    PlaceCovariance calibration{};  ///< by the cameras' own uncertainty: alike for places near to each other
    double epipolar = 0.0;          ///< px: how far the right point is from the left one's epipolar line, signed
    double surprise = 0.0;          ///< chi-squared of that, one degree of freedom
    /// 1 sigma along x, y, z of both together, metres.
    [[nodiscard]] Vec3 sigma() const;
};

/// Least squares in both pictures, with covariance to first order. Refused, with the reason, for pixels that the model
/// does not reach, rays that are parallel, and places behind a camera. Some 5 µs.
[[nodiscard]] std::expected<Triangulated, std::string> triangulate(const CameraSet& pair, const SeenPoint& left,
                                                                   const SeenPoint& right);

/// Distance, px of the right picture without distortion, of the right point from the left one's epipolar line; NaN for
/// pixels that the model does not reach.
[[nodiscard]] double epipolar_distance(const CameraSet& pair, const Pixel& left, const Pixel& right);

/// A place of c in the right camera's frame.
[[nodiscard]] Vec3 in_right(const CameraSet& pair, const Vec3& place);

}  // namespace sc::host
