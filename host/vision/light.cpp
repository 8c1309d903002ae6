// SPDX-License-Identifier: Apache-2.0
#include "host/vision/light.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace sc::host {

cv::Mat light_of(const GreyImage& image) {
    cv::Mat out(image.height, image.width, CV_32F);
    const float scale = 1.0F / static_cast<float>(image.full_scale);
    for (int row = 0; row < image.height; ++row) {
        for (int column = 0; column < image.width; ++column) {
            out.at<float>(row, column) = scale * static_cast<float>(image.at(column, row));
        }
    }
    return out;
}

double noise_of(const cv::Mat& light) {
    constexpr double kMadToSigma = 1.4826;
    std::vector<float> steps;
    for (int row = 0; row < light.rows; row += 2) {
        for (int column = 0; column + 1 < light.cols; column += 2) {
            steps.push_back(std::abs(light.at<float>(row, column + 1) - light.at<float>(row, column)));
        }
    }
    std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
    return kMadToSigma * static_cast<double>(steps[steps.size() / 2]) / std::numbers::sqrt2;
}

}  // namespace sc::host
