// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "host/vision/grey_image.hpp"

namespace sc::host {

/// The picture as CV_32F, 0 to 1.
[[nodiscard]] cv::Mat light_of(const GreyImage& image);

/// Noise of a pixel (1 sigma) from neighbours' differences, by their median: edges do not count.
[[nodiscard]] double noise_of(const cv::Mat& light);

}  // namespace sc::host
