// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "host/vision/ellipse.hpp"

namespace sc::host {

struct Candidate {
    Ellipse ellipse;   ///< by moments of the closed outline at the middle of the levels where it is seen
    bool cut = false;  ///< reaches the picture's edge
};

/// Closed outlines near an ellipse that are seen at several levels of the light; the smallest minor semi-axis is 1.5
/// px. Levels are `noise` (of a pixel, 1 sigma) apart at least, so that noise alone is not seen at several.
[[nodiscard]] std::vector<Candidate> find_candidates(const cv::Mat& light, double noise);

}  // namespace sc::host
