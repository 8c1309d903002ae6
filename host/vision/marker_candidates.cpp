// SPDX-License-Identifier: Apache-2.0
#include "host/vision/marker_candidates.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <opencv2/imgproc.hpp>

#include "host/vision/dual_conic.hpp"

namespace sc::host {
namespace {

constexpr double kMostLevels = 40.0;
constexpr std::size_t kFewestLevels = 3;
constexpr double kPreBlurPx = 0.8;
constexpr double kLeastMinorPx = 1.5;
constexpr double kLargestShare = 0.7;  ///< of the picture's smaller side, the minor axis
constexpr double kLooseMisfit = 0.13;  ///< rms of the outline off its ellipse, in radii; a half disc has 0.13
constexpr double kSameCentre = 0.35;   ///< of the minor semi-axis
constexpr double kSameSize = 0.35;     ///< logarithm of the axes' ratio

struct Group {
    std::vector<Candidate> seen;
};

std::optional<Candidate> candidate_of(const std::vector<cv::Point>& outline, const cv::Size& size) {
    if (outline.size() < 8) {
        return std::nullopt;
    }
    const cv::Moments m = cv::moments(outline);
    if (!(m.m00 > 4.0)) {
        return std::nullopt;
    }
    const double four = 4.0 / m.m00;
    const auto ellipse = ellipse_of(m.m10 / m.m00, m.m01 / m.m00, {four * m.mu20, four * m.mu11, four * m.mu02});
    if (!ellipse || ellipse->minor < kLeastMinorPx ||
        2.0 * ellipse->minor > kLargestShare * std::min(size.width, size.height)) {
        return std::nullopt;
    }
    Candidate out{.ellipse = *ellipse};
    const double c = std::cos(ellipse->angle);
    const double s = std::sin(ellipse->angle);
    double squares = 0.0;
    for (const cv::Point& p : outline) {
        const double dx = p.x - ellipse->x;
        const double dy = p.y - ellipse->y;
        const double radius = std::hypot((dx * c + dy * s) / ellipse->major, (dy * c - dx * s) / ellipse->minor);
        squares += (radius - 1.0) * (radius - 1.0);
        out.cut = out.cut || p.x <= 1 || p.y <= 1 || p.x >= size.width - 2 || p.y >= size.height - 2;
    }
    // Corners of a few pixels are the raster's, not the outline's.
    const double raster = 0.5 / ellipse->minor;
    return std::sqrt(squares / static_cast<double>(outline.size())) < kLooseMisfit + 0.5 * raster ? std::optional(out)
                                                                                                  : std::nullopt;
}

bool alike(const Ellipse& a, const Ellipse& b) {
    return std::hypot(a.x - b.x, a.y - b.y) < kSameCentre * std::min(a.minor, b.minor) &&
           std::abs(std::log(a.major / b.major)) < kSameSize && std::abs(std::log(a.minor / b.minor)) < kSameSize;
}

}  // namespace

std::vector<Candidate> find_candidates(const cv::Mat& light, double noise) {
    cv::Mat smooth;
    cv::GaussianBlur(light, smooth, cv::Size(), kPreBlurPx, kPreBlurPx, cv::BORDER_REPLICATE);
    double least = 0.0;
    double most = 0.0;
    cv::minMaxLoc(smooth, &least, &most);
    std::vector<Group> groups;
    const int levels = static_cast<int>(std::min(kMostLevels, (most - least) / noise));
    for (int level = 1; level < levels; ++level) {
        const cv::Mat mask = smooth > least + (most - least) * level / levels;
        std::vector<std::vector<cv::Point>> outlines;
        cv::findContours(mask, outlines, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
        for (const auto& outline : outlines) {
            const auto candidate = candidate_of(outline, light.size());
            if (!candidate) {
                continue;
            }
            const auto found = std::find_if(groups.begin(), groups.end(), [&](const Group& group) {
                return alike(group.seen.back().ellipse, candidate->ellipse);
            });
            if (found != groups.end()) {
                found->seen.push_back(*candidate);
            } else {
                groups.push_back({{*candidate}});
            }
        }
    }
    std::vector<Candidate> out;
    for (const Group& group : groups) {
        if (group.seen.size() >= kFewestLevels) {
            out.push_back(group.seen[group.seen.size() / 2]);
        }
    }
    return out;
}

}  // namespace sc::host
