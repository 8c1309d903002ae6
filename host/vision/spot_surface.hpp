// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <opencv2/core.hpp>

#include "host/vision/circle_fit.hpp"

/// The light of a spot as a surface. For the sources of this folder.

namespace sc::host {

struct SurfaceFit {
    double x = 0.0;
    double y = 0.0;
    double misfit = 0.0;  ///< rms of the light off the surface, over the light, where the spot is bright
};

/// An elliptic Gaussian over a tilted background, by weighted least squares from the start circle (half height). Light
/// on a rough surface scatters in proportion to itself (speckle), so dim flanks tell the centre as well as bright
/// ones: each place counts by 1/((0.03·height)² + (0.2·light)²), which no outline at a few heights can match. The light
/// is smoothed to a tenth of the radius first: a pixel's noise is then spread, and the robust weights judge the
/// surface, not the noise. Where more than a tenth of a mean's pixels are `full` (CV_8U, not 0) it does not count.
/// nullopt where it does not settle within half a radius of the start.
[[nodiscard]] std::optional<SurfaceFit> fit_surface(const cv::Mat& picture, const cv::Mat& full,
                                                    const Circle& in_picture, double height);

}  // namespace sc::host
