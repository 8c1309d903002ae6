// SPDX-License-Identifier: Apache-2.0
#include "host/vision/spot.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "host/formats/text.hpp"
#include "host/vision/light.hpp"
#include "host/vision/spot_outline.hpp"
#include "host/vision/spot_surface.hpp"

namespace sc::host {

namespace {

constexpr double kPreBlurPx = 2.0;
constexpr double kLeastContrast = 6.0;      ///< height over noise
constexpr double kLeastSeparability = 0.5;  ///< share of the grey values' variance that Otsu's split explains
constexpr int kLeastPixels = 40;
constexpr double kLargestShare = 0.6;  ///< of the picture
constexpr double kSecondShare = 0.3;   ///< of the largest region
constexpr double kLargestRoundness = 0.2;
constexpr int kPlaneRounds = 4;
constexpr double kPlaneOutlier = 2.5;
constexpr double kMadToSigma = 1.4826;
constexpr double kLargestMisfit = 0.4;  ///< of the light from its surface, where the surface is to be believed
constexpr double kFull = 0.95;          ///< of full scale: from here on noise and knee make a pixel unsure
constexpr double kDotSizes = 0.5;       ///< a dot's area is within this of the median's

std::unexpected<SpotRefusal> refuse(SpotProblem problem, std::string text) {
    return std::unexpected(SpotRefusal{problem, std::move(text)});
}

/// The picture less the plane through its background, which bright and dark spots hardly move.
cv::Mat flattened(const cv::Mat& light) {
    std::array<double, 3> plane{};
    double limit = 1e9;
    for (int round = 0; round < kPlaneRounds; ++round) {
        cv::Matx33d a = cv::Matx33d::zeros();
        cv::Vec3d b(0.0, 0.0, 0.0);
        for (int row = 0; row < light.rows; row += 4) {
            for (int column = 0; column < light.cols; column += 4) {
                const cv::Vec3d v(1.0, static_cast<double>(column) / light.cols, static_cast<double>(row) / light.rows);
                const double value = static_cast<double>(light.at<float>(row, column));
                if (std::abs(value - plane[0] - plane[1] * v[1] - plane[2] * v[2]) <= limit) {
                    a += v * v.t();
                    b += value * v;
                }
            }
        }
        const cv::Vec3d x = a.solve(b, cv::DECOMP_SVD);
        plane = {x[0], x[1], x[2]};
        std::vector<double> off;
        for (int row = 0; row < light.rows; row += 8) {
            for (int column = 0; column < light.cols; column += 8) {
                off.push_back(std::abs(static_cast<double>(light.at<float>(row, column)) - plane[0] -
                                       plane[1] * column / light.cols - plane[2] * row / light.rows));
            }
        }
        std::nth_element(off.begin(), off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2), off.end());
        limit = std::max(kPlaneOutlier * kMadToSigma * off[off.size() / 2], 1e-3);
    }
    cv::Mat out(light.size(), CV_32F);
    for (int row = 0; row < light.rows; ++row) {
        for (int column = 0; column < light.cols; ++column) {
            out.at<float>(row, column) =
                static_cast<float>(static_cast<double>(light.at<float>(row, column)) - plane[0] -
                                   plane[1] * column / light.cols - plane[2] * row / light.rows);
        }
    }
    return out;
}

/// Otsu's split of a picture.
struct Split {
    cv::Mat grey;  ///< CV_8U, stretched
    cv::Mat mask;  ///< CV_8U, 255 where brighter than the threshold
    double separability = 0.0;
    double height = 0.0;  ///< between the means of both parts, in light
};

Split split_of(const cv::Mat& light) {
    Split out;
    cv::Mat smooth;
    cv::GaussianBlur(light, smooth, cv::Size(), kPreBlurPx, kPreBlurPx, cv::BORDER_REFLECT);
    double least = 0.0;
    double most = 0.0;
    cv::minMaxLoc(smooth, &least, &most);
    const double scale = most > least ? 255.0 / (most - least) : 0.0;
    smooth.convertTo(out.grey, CV_8U, scale, -least * scale);
    cv::threshold(out.grey, out.mask, 0.0, 255.0, cv::THRESH_BINARY | cv::THRESH_OTSU);
    const cv::Scalar all_mean = cv::mean(smooth);
    cv::Scalar mean_in = cv::mean(smooth, out.mask);
    cv::Scalar mean_out = cv::mean(smooth, out.mask == 0);
    const double share = static_cast<double>(cv::countNonZero(out.mask)) / static_cast<double>(out.mask.total());
    double variance = 0.0;
    for (int row = 0; row < smooth.rows; ++row) {
        for (int column = 0; column < smooth.cols; ++column) {
            const double d = static_cast<double>(smooth.at<float>(row, column)) - all_mean[0];
            variance += d * d;
        }
    }
    variance /= static_cast<double>(smooth.total());
    out.height = mean_in[0] - mean_out[0];
    out.separability = variance > 0.0 ? share * (1.0 - share) * out.height * out.height / variance : 0.0;
    return out;
}

struct Region {
    int label = 0;
    int area = 0;
    cv::Rect box;
};

std::vector<Region> regions_of(const cv::Mat& mask, cv::Mat& labels) {
    cv::Mat stats;
    cv::Mat centres;
    const int count = cv::connectedComponentsWithStats(mask, labels, stats, centres, 8, CV_32S);
    std::vector<Region> out;
    for (int i = 1; i < count; ++i) {
        out.push_back({i, stats.at<int>(i, cv::CC_STAT_AREA),
                       cv::Rect(stats.at<int>(i, cv::CC_STAT_LEFT), stats.at<int>(i, cv::CC_STAT_TOP),
                                stats.at<int>(i, cv::CC_STAT_WIDTH), stats.at<int>(i, cv::CC_STAT_HEIGHT))});
    }
    std::sort(out.begin(), out.end(),
              [](const Region& a, const Region& b) { return a.area != b.area ? a.area > b.area : a.label < b.label; });
    return out;
}

bool touches_edge(const Region& region, const cv::Mat& mask) {
    return region.box.x <= 0 || region.box.y <= 0 || region.box.x + region.box.width >= mask.cols ||
           region.box.y + region.box.height >= mask.rows;
}

/// Circle through Canny's edge of the region.
std::optional<Circle> edge_circle(const cv::Mat& labels, const Region& region, std::size_t& points_found) {
    cv::Rect box = region.box;
    box.x -= 2;
    box.y -= 2;
    box.width += 4;
    box.height += 4;
    box &= cv::Rect(0, 0, labels.cols, labels.rows);
    const cv::Mat part = labels(box) == region.label;
    cv::Mat edges;
    cv::Canny(part, edges, 50.0, 150.0);
    std::vector<std::array<double, 2>> points;
    for (int row = 0; row < edges.rows; ++row) {
        for (int column = 0; column < edges.cols; ++column) {
            if (edges.at<std::uint8_t>(row, column) != 0) {
                points.push_back({static_cast<double>(box.x + column), static_cast<double>(box.y + row)});
            }
        }
    }
    points_found = points.size();
    return fit_circle(points);
}

double saturated_share(const GreyImage& image, const Circle& circle) {
    int n = 0;
    int full = 0;
    const int reach = static_cast<int>(std::ceil(circle.radius));
    const int x0 = static_cast<int>(std::lround(circle.x));
    const int y0 = static_cast<int>(std::lround(circle.y));
    for (int row = std::max(0, y0 - reach); row <= std::min(image.height - 1, y0 + reach); ++row) {
        for (int column = std::max(0, x0 - reach); column <= std::min(image.width - 1, x0 + reach); ++column) {
            if (std::hypot(column - circle.x, row - circle.y) <= circle.radius) {
                ++n;
                full += image.at(column, row) >= image.full_scale ? 1 : 0;
            }
        }
    }
    return n > 0 ? static_cast<double>(full) / n : 0.0;
}

std::expected<Spot, SpotRefusal> refined(const GreyImage& image, const cv::Mat& light, const cv::Mat& labels,
                                         const Region& region, const OutlineSettings& settings, double noise) {
    Spot spot;
    const auto edge = edge_circle(labels, region, spot.edge_points);
    if (!edge) {
        return refuse(SpotProblem::not_round,
                      "the outline of the spot is no circle: its edge does not close; look for "
                      "reflections, or take the picture again");
    }
    spot.edge = *edge;
    const auto outline = find_outline(light, *edge, settings);
    if (!outline) {
        return refuse(SpotProblem::not_round,
                      "the outline of the spot does not close at half its height: it reaches the "
                      "picture's edge, or has another beside it; leave more room around it");
    }
    spot.x = outline->circle.x;
    spot.y = outline->circle.y;
    spot.radius = outline->circle.radius;
    spot.sigma = outline->sigma;
    spot.roundness = outline->circle.residual / outline->circle.radius;
    spot.contrast = outline->height / std::max(noise, 1e-4);
    spot.saturated = saturated_share(image, outline->circle);
    if (spot.roundness > kLargestRoundness) {
        return refuse(SpotProblem::not_round, "the outline of the spot is no circle: it is " +
                                                  fixed(100.0 * spot.roundness, 0) +
                                                  " % of its radius off one, rms; look for reflections, or take the "
                                                  "picture again");
    }
    return spot;
}

/// The centre of the light's surface in place of the outlines', where the spot is such a surface.
void take_surface(const GreyImage& image, const cv::Mat& light, double noise, Spot& spot) {
    cv::Mat saturated = cv::Mat::zeros(light.size(), CV_8U);
    for (int row = 0; row < image.height; ++row) {
        for (int column = 0; column < image.width; ++column) {
            saturated.at<std::uint8_t>(row, column) = image.at(column, row) >= kFull * image.full_scale ? 1 : 0;
        }
    }
    const Circle start{.x = spot.x, .y = spot.y, .radius = spot.radius, .residual = 0.0, .used = 0};
    const auto surface = fit_surface(light, saturated, start, spot.contrast * std::max(noise, 1e-4));
    spot.misfit = surface ? surface->misfit : 1.0;
    if (surface && surface->misfit < kLargestMisfit) {
        spot.x = surface->x;
        spot.y = surface->y;
        spot.by_surface = true;
    }
}

std::optional<SpotRefusal> unfit(const Split& split, const std::vector<Region>& regions, double noise) {
    // Smoothing leaves little of the pixels' noise: what is above it must stand out well.
    if (!(split.height > kLeastContrast * std::max(noise, 1e-3))) {
        return SpotRefusal{SpotProblem::flat,
                           "there is no spot: the brightest part is " + fixed(split.height * 100.0, 1) +
                               " % of full scale above the rest, with a noise of " + fixed(noise * 100.0, 2) +
                               " %; switch the laser on, or expose for longer"};
    }
    if (!(split.separability > kLeastSeparability)) {
        return SpotRefusal{SpotProblem::no_split,
                           "no threshold parts the spot from the background: Otsu's split explains " +
                               fixed(split.separability * 100.0, 0) +
                               " % of the grey values' variance; shade the surface, or expose for less long"};
    }
    if (regions.empty() || regions.front().area < kLeastPixels) {
        return SpotRefusal{SpotProblem::small,
                           "the spot has " + std::to_string(regions.empty() ? 0 : regions.front().area) + " pixels, " +
                               std::to_string(kLeastPixels) + " are needed; bring the camera nearer"};
    }
    return std::nullopt;
}

std::string place_text(const Region& region) {
    return "(" + std::to_string(region.box.x + region.box.width / 2) + ", " +
           std::to_string(region.box.y + region.box.height / 2) + ")";
}

/// The dots among the regions of one polarity; empty if there are not `count` of like size.
std::vector<Region> dots_among(const std::vector<Region>& regions, const cv::Mat& mask, std::size_t count) {
    std::vector<Region> out;
    for (const Region& region : regions) {
        if (region.area >= kLeastPixels && !touches_edge(region, mask)) {
            out.push_back(region);
        }
    }
    if (out.size() < count) {
        return {};
    }
    // Largest first: what is beside the dots is dirt, smaller than half a dot.
    const std::size_t half = count / 2;
    const double middle = out[half].area;
    std::erase_if(out, [&](const Region& region) {
        return region.area < (1.0 - kDotSizes) * middle || region.area > (1.0 + kDotSizes) * middle;
    });
    return out.size() == count ? out : std::vector<Region>{};
}

}  // namespace

const char* name_of(SpotProblem problem) noexcept {
    switch (problem) {
        case SpotProblem::flat: return "flat";
        case SpotProblem::no_split: return "no_split";
        case SpotProblem::small: return "small";
        case SpotProblem::large: return "large";
        case SpotProblem::cut: return "cut";
        case SpotProblem::several: return "several";
        case SpotProblem::not_round: return "not_round";
        case SpotProblem::wrong_count: return "wrong_count";
    }
    return "unknown";
}

std::expected<Spot, SpotRefusal> find_spot(const GreyImage& image) {
    if (image.width < 16 || image.height < 16) {
        return refuse(SpotProblem::small, "the picture has " + std::to_string(image.width) + " x " +
                                              std::to_string(image.height) + " pixels; give a larger part of it");
    }
    const cv::Mat light = light_of(image);
    const double noise = noise_of(light);
    const Split split = split_of(flattened(light));
    cv::Mat labels;
    const std::vector<Region> regions = regions_of(split.mask, labels);
    if (auto refusal = unfit(split, regions, noise)) {
        return std::unexpected(*refusal);
    }
    const Region& spot = regions.front();
    if (spot.area > kLargestShare * static_cast<double>(image.pixel.size())) {
        return refuse(SpotProblem::large, "the bright part fills " +
                                              fixed(100.0 * spot.area / static_cast<double>(image.pixel.size()), 0) +
                                              " % of the picture: this is no spot; expose for less long, or leave more "
                                              "room around it");
    }
    if (touches_edge(spot, split.mask)) {
        return refuse(SpotProblem::cut, "the spot at " + place_text(spot) +
                                            " reaches the picture's edge: its centre cannot be told; leave more room "
                                            "around it");
    }
    if (regions.size() > 1 && regions[1].area > kSecondShare * spot.area) {
        return refuse(SpotProblem::several, "there are several spots, at " + place_text(spot) + " and " +
                                                place_text(regions[1]) +
                                                "; switch one laser on at a time, keep reflections out");
    }
    auto found = refined(image, light, labels, spot, {}, noise);
    if (found) {
        take_surface(image, light, noise, *found);
    }
    return found;
}

std::expected<std::vector<Spot>, SpotRefusal> find_dots(const GreyImage& image, std::size_t count) {
    constexpr OutlineSettings kDisc{
        .smoothing = 0.0, .least_smoothing_px = 1.0, .background_from = 1.2, .background_to = 1.4, .search_to = 1.4};
    const cv::Mat light = light_of(image);
    const double noise = noise_of(light);
    const cv::Mat flat = flattened(light);
    for (const bool dark : {true, false}) {
        const cv::Mat bright = dark ? cv::Mat(-flat) : flat;
        const Split split = split_of(bright);
        cv::Mat labels;
        const std::vector<Region> dots = dots_among(regions_of(split.mask, labels), split.mask, count);
        if (dots.empty()) {
            continue;
        }
        std::vector<Spot> out;
        for (const Region& region : dots) {
            const auto dot = refined(image, bright, labels, region, kDisc, noise);
            if (!dot) {
                return refuse(dot.error().problem, "the dot at " + place_text(region) + ": " + dot.error().text);
            }
            out.push_back(*dot);
        }
        return out;
    }
    return refuse(SpotProblem::wrong_count, "there are not " + std::to_string(count) +
                                                " dots of like size, dark or bright, clear of the picture's edge; "
                                                "light the plate evenly, and keep the whole pattern in the picture");
}

}  // namespace sc::host
