// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <opencv2/core.hpp>

#include "host/vision/circle_fit.hpp"

/// Sub-pixel outlines of a bright blob. For the sources of this folder.

namespace sc::host {

/// How an outline is looked for; lengths are in radii of the first circle unless they say px.
struct OutlineSettings {
    double smoothing = 0.35;
    double least_smoothing_px = 1.0;
    double background_from = 1.8;
    double background_to = 2.4;
    double search_to = 2.2;
};

struct Outline {
    Circle circle;  ///< centre: mean of those of five heights; radius and residual: of the half height
    double sigma = 0.0;
    double height = 0.0;  ///< top over background, in the picture's unit
};

/// `light`: CV_32F, the blob brighter than its surroundings. nullopt where no outline closes.
[[nodiscard]] std::optional<Outline> find_outline(const cv::Mat& light, const Circle& start,
                                                  const OutlineSettings& settings);

}  // namespace sc::host
