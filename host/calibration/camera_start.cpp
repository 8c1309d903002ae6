// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/camera_start.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kLeastTiltTerm = 1e-3;  ///< of Zhang's equations: below, a view says nothing of the focal length
constexpr double kOneDistance = 0.1;     ///< spread of distances
constexpr double kLeastCover = 0.6;      ///< of the way to the corner of the picture
constexpr double kFewSigma = 3.0;

struct Weighted {
    double value = 0.0;
    double weight = 0.0;
};

double weighted_median(std::vector<Weighted> all) {
    std::ranges::sort(all, {}, &Weighted::value);
    double total = 0.0;
    for (const Weighted& w : all) {
        total += w.weight;
    }
    double sum = 0.0;
    for (const Weighted& w : all) {
        sum += w.weight;
        if (sum >= 0.5 * total) {
            return w.value;
        }
    }
    return 0.0;
}

/// f² of one view: h1ᵀ·ω·h2 = 0 and h1ᵀ·ω·h1 = h2ᵀ·ω·h2 with ω = diag(1/f², 1/f², 1).
std::optional<Weighted> focal_of_view(const BoardView& view, double middle_x, double middle_y, double scale) {
    std::vector<PlanePair> pairs;
    for (const BoardPoint& p : view.points) {
        pairs.push_back({.board = {p.place.x, p.place.y},
                         .seen = {(p.seen[0] - middle_x) / scale, (p.seen[1] - middle_y) / scale}});
    }
    const auto h = robust_homography(pairs);
    if (!h) {
        return std::nullopt;
    }
    const Eigen::Vector3d a = h->col(0) / h->col(0).norm();
    const Eigen::Vector3d b = h->col(1) / h->col(0).norm();
    const Eigen::Vector2d in(a[0] * b[0] + a[1] * b[1], a.head<2>().squaredNorm() - b.head<2>().squaredNorm());
    const Eigen::Vector2d out(a[2] * b[2], a[2] * a[2] - b[2] * b[2]);
    const double inverse = -in.dot(out) / in.squaredNorm();
    if (!(inverse > 0.0) || !(out.norm() > kLeastTiltTerm * kLeastTiltTerm)) {
        return std::nullopt;
    }
    return Weighted{.value = 1.0 / inverse * scale * scale, .weight = out.norm()};
}

std::array<double, CameraModel::kParameters> values_of(const CameraModel& m) {
    return {m.focal_x,       m.focal_y,       m.middle_x,      m.middle_y,     m.distortion[0],
            m.distortion[1], m.distortion[2], m.distortion[3], m.distortion[4]};
}

void fix_distortion(const BoardFit& fit, std::size_t camera, const CameraFitOptions& options, FixedParameters& fixed,
                    std::vector<std::string>& notes) {
    const auto values = values_of(fit.state.cameras[camera]);
    const double r = reach_of(fit, camera);
    const double focal = focal_of(fit.state.cameras[camera]);
    const std::array<double, 5> at_edge{r * r * r, std::pow(r, 5), 3.0 * r * r, 3.0 * r * r, std::pow(r, 7)};
    for (const std::size_t k : {8U, 5U, 6U, 7U, 4U}) {  // the highest order first, one at a time
        const auto at = static_cast<Eigen::Index>(CameraModel::kParameters * camera + k);
        const double sigma = std::sqrt(std::max(fit.covariance(at, at), 0.0));
        const double edge = focal * at_edge[k - 4] * sigma;
        if (!fixed[k] && edge > options.most_edge_sigma_px && std::abs(values[k]) < kFewSigma * sigma) {
            fixed[k] = true;
            notes.push_back(fmt::format(
                "the views cannot show {}: its 1 sigma moves the outermost point by {:.1f} px; it stays 0. Take views "
                "with the board in the corners of the picture",
                kCameraParameters[k], edge));
            return;
        }
    }
}

}  // namespace

double focal_of(const CameraModel& camera) { return std::sqrt(camera.focal_x * camera.focal_y); }

FixedParameters fixed_of(const std::filesystem::path& file, const std::vector<std::string>& names) {
    FixedParameters out{};
    for (const std::string& name : names) {
        const auto at = std::ranges::find(kCameraParameters, name);
        if (at == kCameraParameters.end()) {
            throw InputError({.file = file.string(),
                              .problem = "no parameter of a camera",
                              .value = name,
                              .action = "use fx, fy, cx, cy, k1, k2, p1, p2, k3"});
        }
        out[static_cast<std::size_t>(at - kCameraParameters.begin())] = true;
    }
    return out;
}

std::vector<std::string> names_of(const FixedParameters& fixed) {
    std::vector<std::string> out;
    for (std::size_t k = 0; k < fixed.size(); ++k) {
        if (fixed[k]) {
            out.emplace_back(kCameraParameters[k]);
        }
    }
    return out;
}

CameraModel start_camera(const std::vector<BoardView>& views, double focal) {
    const double width = views.front().width;
    const double height = views.front().height;
    CameraModel out{
        .focal_x = focal, .focal_y = focal, .middle_x = 0.5 * (width - 1.0), .middle_y = 0.5 * (height - 1.0)};
    if (!(focal > 0.0)) {
        std::vector<Weighted> all;
        for (const BoardView& view : views) {
            if (const auto squared = focal_of_view(view, out.middle_x, out.middle_y, width)) {
                all.push_back({.value = std::sqrt(squared->value), .weight = squared->weight});
            }
        }
        const double found = all.empty() ? width : weighted_median(std::move(all));
        out.focal_x = out.focal_y = std::clamp(found, 0.3 * width, 30.0 * width);
    }
    return out;
}

double reach_of(const BoardFit& fit, std::size_t camera) {
    double reach = 0.0;
    for (const PointFit& p : fit.points) {
        if (p.used && p.camera == camera) {
            if (const auto ray = undistorted(fit.state.cameras[camera], p.seen)) {
                reach = std::max(reach, std::hypot(ray->x, ray->y));
            }
        }
    }
    return reach;
}

bool fix_blind(const std::filesystem::path& file, const BoardFit& fit, std::size_t camera, const CameraRecord& record,
               const CameraFitOptions& options, FixedParameters& fixed, std::vector<std::string>& notes) {
    const auto sigma = [&](std::size_t k) {
        const auto at = static_cast<Eigen::Index>(CameraModel::kParameters * camera + k);
        return std::sqrt(std::max(fit.covariance(at, at), 0.0));
    };
    const CameraModel& model = fit.state.cameras[camera];
    const double focal_sigma = std::max(sigma(0) / model.focal_x, sigma(1) / model.focal_y);
    double most_tilt = 0.0;
    for (const ViewFit& view : fit.views) {
        most_tilt = view.used ? std::max(most_tilt, view.tilt) : most_tilt;
    }
    if (!(focal_sigma < options.most_focal_sigma) || !std::isfinite(focal_sigma)) {
        throw InputError({.file = file.string(),
                          .problem = "these views cannot show the focal length: all are nearly parallel to the picture "
                                     "plane, where it and the distance cannot be told apart",
                          .value = fmt::format("tilts up to {:.1f} deg, 1 sigma {:.0f} % of {:.0f} px",
                                               most_tilt / kDegree, 100.0 * focal_sigma, focal_of(model)),
                          .action = "take views with the board tilted by 20 to 45 degrees about both axes, or give the "
                                    "focal length (--focal-px with --fix fx,fy)"});
    }
    const std::size_t before = notes.size();
    for (const std::size_t k : {2U, 3U}) {
        if (!fixed[k] && sigma(k) > options.most_middle_sigma * record.width) {
            notes.push_back(fmt::format(
                "the views cannot show {}: 1 sigma is {:.0f} px; it stays the picture's middle. Tilt the board about "
                "both axes",
                kCameraParameters[k], sigma(k)));
            fixed[k] = true;
        }
    }
    if (notes.size() == before) {
        fix_distortion(fit, camera, options, fixed, notes);
    }
    return notes.size() > before;
}

void note_views(const BoardFit& fit, std::size_t camera, const CameraRecord& record, std::vector<std::string>& notes) {
    double near = 1e9;
    double far = 0.0;
    for (const ViewFit& view : fit.views) {
        if (view.used) {
            near = std::min(near, view.translation.z);
            far = std::max(far, view.translation.z);
        }
    }
    if (far - near < kOneDistance * far) {
        notes.push_back(fmt::format(
            "all views are at one distance, {:.0f} to {:.0f} mm: what is nearer or further rests on the model "
            "alone",
            1e3 * near, 1e3 * far));
    }
    double outermost = 0.0;
    for (const PointFit& p : fit.points) {
        if (p.used && p.camera == camera) {
            outermost =
                std::max(outermost, std::hypot(p.seen[0] - 0.5 * record.width, p.seen[1] - 0.5 * record.height));
        }
    }
    const double share = outermost / std::hypot(0.5 * record.width, 0.5 * record.height);
    if (share < kLeastCover) {
        notes.push_back(
            fmt::format("the points reach {:.0f} % of the way to the picture's corners: further out the "
                        "distortion is not calibrated",
                        100.0 * share));
    }
}

}  // namespace sc::host
