// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "host/vision/ellipse.hpp"
#include "host/vision/marker.hpp"

/// Ellipses from the gradients of a picture, each gradient taken as a tangent: J.-N. Ouellet, P. Hébert, "Precise
/// ellipse estimation without contour point extraction", Machine Vision and Applications 21 (2009).

namespace sc::host {

[[nodiscard]] EllipseShape shape_of(const Ellipse& ellipse);
/// None if the matrix is not positive definite.
[[nodiscard]] std::optional<Ellipse> ellipse_of(double x, double y, const EllipseShape& shape);
/// Of a point from the ellipse, positive outside, to first order. Pixels.
[[nodiscard]] double distance_from(const Ellipse& ellipse, double x, double y);

/// Derivatives of the light along columns and rows, per pixel.
struct Gradients {
    cv::Mat along;   ///< CV_32F, row kernel of the smoothed value
    cv::Mat across;  ///< CV_32F, of the derivative
    cv::Mat x;       ///< CV_32F
    cv::Mat y;       ///< CV_32F
};
[[nodiscard]] Gradients gradients_of(const cv::Mat& light, double smoothing_px);

/// A part of the outline.
struct EdgeSector {
    double distance = 0.0;  ///< px, of the edge from the ellipse, outwards
    double strength = 0.0;  ///< largest step across the edge, light per pixel
    bool used = true;
};

struct DualConicFit {
    Ellipse ellipse;
    std::array<double, 3> covariance{};  ///< of the centre: xx, xy, yy, for pixels' noise of 1 (light); px²
    std::vector<EdgeSector> sectors;     ///< round the outline, from the major axis on
    double step = 0.0;                   ///< light: outside less inside
};

/// The ellipse near `start`; none if the tangents give none. Parts of the outline that lie off it, or have no edge, are
/// left out.
[[nodiscard]] std::optional<DualConicFit> fit_dual_conic(const Gradients& gradients, const cv::Mat& light,
                                                         const Ellipse& start, const MarkerSettings& settings);

}  // namespace sc::host
