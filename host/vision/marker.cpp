// SPDX-License-Identifier: Apache-2.0
#include "host/vision/marker.hpp"

#include <algorithm>
#include <cmath>
#include <expected>
#include <numbers>
#include <string>

#include "host/formats/text.hpp"
#include "host/vision/dual_conic.hpp"
#include "host/vision/light.hpp"
#include "host/vision/marker_candidates.hpp"

namespace sc::host {
namespace {

constexpr double kRoughPx = 0.7;        ///< that an outline of whole pixels may be too small
constexpr double kRoomPx = 4.0;         ///< about an outline
constexpr double kLeastContrast = 8.0;  ///< step over noise
constexpr double kMostMissing = 0.12;   ///< share of the outline
constexpr double kMostCovered = 0.5;    ///< beyond, what is left says nothing
constexpr double kMisfitPx = 0.15;
constexpr double kMisfitShare = 0.008;   ///< of the minor semi-axis
constexpr double kMostSaturated = 0.35;  ///< share of the edge's pixels
constexpr double kMostUneven = 0.3;      ///< how much more of it on one side than on the other
constexpr double kSamePlacePx = 1.0;
constexpr double kSameSize = 0.1;
constexpr double kSigmaShown = 20.0;

std::string place_text(const Ellipse& e) { return "(" + fixed(e.x, 0) + ", " + fixed(e.y, 0) + ")"; }

std::unexpected<MarkerRefusal> refuse(MarkerProblem problem, const Ellipse& where, const std::string& text) {
    return std::unexpected(
        MarkerRefusal{.problem = problem, .where = where, .text = "the marker at " + place_text(where) + " " + text});
}

struct Saturation {
    double share = 0.0;
    double uneven = 0.0;
};

/// Of the pixels within 1.5 px of the edge.
Saturation saturation_of(const GreyImage& image, const Ellipse& e) {
    const int reach = static_cast<int>(std::ceil(e.major)) + 3;
    const int column0 = static_cast<int>(std::lround(e.x));
    const int row0 = static_cast<int>(std::lround(e.y));
    double count = 0.0;
    double full = 0.0;
    double along_x = 0.0;
    double along_y = 0.0;
    for (int row = std::max(0, row0 - reach); row <= std::min(image.height - 1, row0 + reach); ++row) {
        for (int column = std::max(0, column0 - reach); column <= std::min(image.width - 1, column0 + reach);
             ++column) {
            if (std::abs(distance_from(e, column, row)) < 1.5) {
                count += 1.0;
                if (image.at(column, row) >= image.full_scale) {
                    const double radius = std::max(std::hypot(column - e.x, row - e.y), 1e-9);
                    full += 1.0;
                    along_x += (column - e.x) / radius;
                    along_y += (row - e.y) / radius;
                }
            }
        }
    }
    return count > 0.0 ? Saturation{.share = full / count, .uneven = 2.0 * std::hypot(along_x, along_y) / count}
                       : Saturation{};
}

std::expected<Marker, MarkerRefusal> judged_outline(const DualConicFit& fit) {
    const Ellipse& e = fit.ellipse;
    double squares = 0.0;
    double used = 0.0;
    for (const EdgeSector& sector : fit.sectors) {
        if (sector.used) {
            squares += sector.distance * sector.distance;
            used += 1.0;
        }
    }
    const double missing = 1.0 - used / static_cast<double>(fit.sectors.size());
    const double misfit = used > 0.0 ? std::sqrt(squares / used) : 0.0;
    if (missing > kMostCovered || misfit > std::max(kMisfitPx, kMisfitShare * e.minor)) {
        return refuse(MarkerProblem::not_ellipse, e,
                      "is no ellipse: its edge lies " + fixed(misfit, 2) + " px off one, rms, and " +
                          fixed(100.0 * missing, 0) + " % of it lies elsewhere; use round, flat markers");
    }
    if (missing > kMostMissing) {
        return refuse(MarkerProblem::occluded, e,
                      "is covered in part: " + fixed(100.0 * missing, 0) +
                          " % of its outline is missing or not where the rest has it; clear the view or clean it");
    }
    Marker out{.ellipse = e};
    out.misfit = misfit;
    out.dark = fit.step > 0.0;
    return out;
}

std::expected<Marker, MarkerRefusal> measured(const GreyImage& image, const cv::Mat& light, const Gradients& gradients,
                                              double noise, const Candidate& candidate,
                                              const MarkerSettings& settings) {
    const Ellipse& rough = candidate.ellipse;
    const EllipseShape shape = shape_of(rough);
    const double room_x = std::sqrt(shape[0]) + kRoomPx;
    const double room_y = std::sqrt(shape[2]) + kRoomPx;
    if (candidate.cut || rough.x < room_x || rough.y < room_y || rough.x > image.width - 1.0 - room_x ||
        rough.y > image.height - 1.0 - room_y) {
        return refuse(MarkerProblem::cut, rough, "reaches the picture's edge; leave four pixels around it");
    }
    if (rough.minor / rough.major < settings.least_ratio) {
        return refuse(MarkerProblem::oblique, rough,
                      "is seen at too flat an angle, about " +
                          fixed(std::acos(rough.minor / rough.major) * 180.0 / std::numbers::pi, 0) +
                          " deg from square; turn it to the camera");
    }
    if (rough.minor < settings.least_minor_px - kRoughPx) {
        return refuse(MarkerProblem::small, rough,
                      "is too small: its minor semi-axis has " + fixed(rough.minor, 1) + " px, " +
                          fixed(settings.least_minor_px, 1) + " are needed; go nearer or use larger markers");
    }
    const auto fit = fit_dual_conic(gradients, light, rough, settings);
    if (!fit) {
        return refuse(MarkerProblem::not_ellipse, rough,
                      "is no ellipse: the tangents of its edge give none; use round, flat markers");
    }
    const Ellipse& e = fit->ellipse;
    if (e.minor < settings.least_minor_px) {
        return refuse(MarkerProblem::small, e,
                      "is too small: its minor semi-axis has " + fixed(e.minor, 1) + " px, " +
                          fixed(settings.least_minor_px, 1) + " are needed; go nearer or use larger markers");
    }
    auto out = judged_outline(*fit);
    if (!out) {
        return out;
    }
    if (e.minor / e.major < settings.least_ratio) {
        return refuse(MarkerProblem::oblique, e,
                      "is seen at too flat an angle, " +
                          fixed(std::acos(e.minor / e.major) * 180.0 / std::numbers::pi, 0) +
                          " deg from square; turn it to the camera");
    }
    out->contrast = std::abs(fit->step) / noise;
    if (out->contrast < kLeastContrast) {
        return refuse(MarkerProblem::faint, e,
                      "is too faint: its edge is " + fixed(out->contrast, 1) + " times the noise, " +
                          fixed(kLeastContrast, 0) + " are needed; give more light");
    }
    const Saturation saturation = saturation_of(image, e);
    if (saturation.share > kMostSaturated || saturation.uneven > kMostUneven) {
        return refuse(MarkerProblem::saturated, e,
                      "is clipped at full scale: " + fixed(100.0 * saturation.share, 0) +
                          " % of its edge's pixels, unevenly by " + fixed(100.0 * saturation.uneven, 0) +
                          " %; expose for less long");
    }
    out->saturated = saturation.share;
    for (std::size_t k = 0; k < 3; ++k) {
        out->covariance[k] = fit->covariance[k] * noise * noise;
    }
    out->sigma = std::sqrt(std::max(out->covariance[0], out->covariance[2]));
    return out;
}

bool same(const Ellipse& a, const Ellipse& b) {
    return std::hypot(a.x - b.x, a.y - b.y) < kSamePlacePx &&
           std::abs(a.major - b.major) < std::max(kSamePlacePx, kSameSize * a.major) &&
           std::abs(a.minor - b.minor) < std::max(kSamePlacePx, kSameSize * a.minor);
}

void add_ellipse(Drawing& drawing, const Ellipse& e, Stroke stroke) {
    constexpr int kPieces = 72;
    const auto at = [&](int k) {
        const double turn = 2.0 * std::numbers::pi * k / kPieces;
        const double u = e.major * std::cos(turn);
        const double v = e.minor * std::sin(turn);
        return std::array{e.x + u * std::cos(e.angle) - v * std::sin(e.angle),
                          e.y + u * std::sin(e.angle) + v * std::cos(e.angle)};
    };
    for (int k = 0; k < kPieces; ++k) {
        drawing.shapes.emplace_back(Drawing::Line{.from = at(k), .to = at(k + 1), .stroke = stroke});
    }
}

}  // namespace

const char* name_of(MarkerProblem problem) noexcept {
    switch (problem) {
        case MarkerProblem::cut: return "cut";
        case MarkerProblem::small: return "small";
        case MarkerProblem::oblique: return "oblique";
        case MarkerProblem::faint: return "faint";
        case MarkerProblem::saturated: return "saturated";
        case MarkerProblem::occluded: return "occluded";
        case MarkerProblem::not_ellipse: return "not_ellipse";
    }
    return "unknown";
}

MarkersFound find_markers(const GreyImage& image, const MarkerSettings& settings) {
    MarkersFound out;
    if (image.width < 16 || image.height < 16) {
        return out;
    }
    const cv::Mat light = light_of(image);
    // Rounding to whole grey values is the least noise there is.
    const double noise = std::max(noise_of(light), 1.0 / (image.full_scale * std::sqrt(12.0)));
    const Gradients gradients = gradients_of(light, settings.smoothing_px);
    for (const Candidate& candidate : find_candidates(light, noise)) {
        const auto marker = measured(image, light, gradients, noise, candidate, settings);
        if (marker) {
            const bool known = std::any_of(out.markers.begin(), out.markers.end(),
                                           [&](const Marker& other) { return same(other.ellipse, marker->ellipse); });
            if (!known) {
                out.markers.push_back(*marker);
            }
        } else {
            out.refused.push_back(marker.error());
        }
    }
    // One outline may have been a candidate twice: what was measured once is not refused as well.
    std::vector<MarkerRefusal> refused;
    for (const MarkerRefusal& r : out.refused) {
        const auto near = [&](const Ellipse& e) {
            return std::hypot(e.x - r.where.x, e.y - r.where.y) < 0.5 * std::max(e.minor, r.where.minor);
        };
        if (std::none_of(out.markers.begin(), out.markers.end(), [&](const Marker& m) { return near(m.ellipse); }) &&
            std::none_of(refused.begin(), refused.end(), [&](const MarkerRefusal& o) { return near(o.where); })) {
            refused.push_back(r);
        }
    }
    out.refused = std::move(refused);
    std::sort(out.markers.begin(), out.markers.end(), [](const Marker& a, const Marker& b) {
        return a.ellipse.y != b.ellipse.y ? a.ellipse.y < b.ellipse.y : a.ellipse.x < b.ellipse.x;
    });
    return out;
}

Drawing overlay_of(const GreyImage& image, const MarkersFound& found) {
    Drawing out{.width = image.width, .height = image.height, .shapes = {}};
    for (const Marker& m : found.markers) {
        add_ellipse(out, m.ellipse, Stroke::thin);
        const std::array at{m.ellipse.x, m.ellipse.y};
        out.shapes.emplace_back(Drawing::Disc{.centre = at, .radius = std::max(1.5, kSigmaShown * m.sigma)});
    }
    for (const MarkerRefusal& r : found.refused) {
        add_ellipse(out, r.where, Stroke::beam);
        out.shapes.emplace_back(Drawing::Text{.at = {r.where.x, r.where.y - r.where.major - 3.0},
                                              .font = Font::small,
                                              .anchor = Anchor::middle,
                                              .text = name_of(r.problem)});
    }
    return out;
}

}  // namespace sc::host
