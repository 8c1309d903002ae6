// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/stereo_fit.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "host/calibration/camera_start.hpp"
#include "host/formats/error.hpp"
#include "host/vision/triangulation.hpp"

namespace sc::host {
namespace {

constexpr std::size_t kFewestCommon = 3;
constexpr std::size_t kNine = CameraModel::kParameters;

Motion pose_of(const ViewFit& view) { return {to_eigen(view.rotation), to_eigen(view.translation)}; }

struct Pairing {
    std::vector<BoardSights> sights;
    std::vector<Motion> boards;  ///< left_from_board
    Motion right_from_left;
};

double gap(const Motion& a, const Motion& b) {
    return log_turn(a.r * b.r.transpose()).norm() + (a.t - b.t).norm() / std::max(a.t.norm(), 1e-9);
}

/// The pose that most views agree on: the one with the least median difference from the others.
Motion most_agreed(const std::vector<Motion>& all) {
    std::size_t best = 0;
    double least = 1e300;
    for (std::size_t i = 0; i < all.size(); ++i) {
        std::vector<double> gaps;
        for (const Motion& other : all) {
            gaps.push_back(gap(all[i], other));
        }
        std::ranges::sort(gaps);
        const double middle = gaps[gaps.size() / 2];
        if (middle < least) {
            least = middle;
            best = i;
        }
    }
    return all[best];
}

const BoardView* named(const std::vector<BoardView>& views, const std::string& name) {
    const auto at = std::ranges::find(views, name, &BoardView::name);
    return at != views.end() ? &*at : nullptr;
}

std::map<std::string, Motion> used_poses(const CameraFit& fit) {
    std::map<std::string, Motion> out;
    for (const ViewFit& view : fit.views) {
        if (view.used) {
            out.emplace(view.name, pose_of(view));
        }
    }
    return out;
}

Pairing paired(const std::filesystem::path& file, const std::vector<BoardView>& left,
               const std::vector<BoardView>& right, const CameraFit& left_fit, const CameraFit& right_fit) {
    const auto in_left = used_poses(left_fit);
    const auto in_right = used_poses(right_fit);
    std::vector<Motion> relative;
    for (const auto& [name, pose] : in_left) {
        if (const auto other = in_right.find(name); other != in_right.end()) {
            relative.push_back(other->second * pose.inverse());
        }
    }
    if (relative.size() < kFewestCommon) {
        throw InputError({.file = file.string(),
                          .problem = "too few views that both cameras have seen and that fit",
                          .value = std::to_string(relative.size()),
                          .action = "views are paired by name: call left and right pictures of a moment alike; 3 are "
                                    "needed, 10 or more are good"});
    }
    Pairing out;
    out.right_from_left = most_agreed(relative);
    for (const auto& [name, pose] : in_left) {
        out.sights.push_back(
            {.name = name, .seen = {named(left, name), in_right.contains(name) ? named(right, name) : nullptr}});
        out.boards.push_back(pose);
    }
    for (const auto& [name, pose] : in_right) {
        if (!in_left.contains(name)) {
            out.sights.push_back({.name = name, .seen = {nullptr, named(right, name)}});
            out.boards.push_back(out.right_from_left.inverse() * pose);
        }
    }
    return out;
}

CameraRecord record_of(const BoardFit& fit, std::size_t camera, const CameraFit& alone, const FixedParameters& fixed) {
    CameraRecord out = alone.camera;
    out.id = camera == 0 ? "left" : "right";
    out.model = fit.state.cameras[camera];
    out.fixed = names_of(fixed);
    out.rms = rms_of(fit, camera);
    out.reach = reach_of(fit, camera);
    return out;
}

void take_covariance(const BoardFit& fit, StereoFit& out) {
    const auto size = static_cast<std::size_t>(fit.covariance.rows());
    out.set.covariance.assign(size, std::vector<double>(size));
    for (std::size_t i = 0; i < size; ++i) {
        for (std::size_t k = 0; k < size; ++k) {
            out.set.covariance[i][k] = fit.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
        }
    }
    const auto sigma = [&](std::size_t i) { return std::sqrt(std::max(out.set.covariance[i][i], 0.0)); };
    for (std::size_t k = 0; k < kNine; ++k) {
        out.left_sigma[k] = sigma(k);
        out.right_sigma[k] = sigma(kNine + k);
    }
    for (std::size_t k = 0; k < 6; ++k) {
        out.pose_sigma[k] = sigma(2 * kNine + k);
    }
    // The left camera's place in the right one's frame is as far away as the other way round.
    const Eigen::Vector3d t = fit.state.right_from_left.t;
    const Eigen::Vector3d along = t.normalized();
    out.baseline = t.norm();
    out.baseline_sigma = std::sqrt(std::max(along.dot(fit.covariance.bottomRightCorner<3, 3>() * along), 0.0));
}

/// Points that both cameras have seen, by view and name.
struct Twin {
    SeenPoint left;
    SeenPoint right;
    Vec3 board;
};

std::vector<Twin> twins_of(const BoardSights& sights, const BoardFit& fit, std::size_t view) {
    std::map<std::pair<int, int>, std::array<const PointFit*, 2>> seen;
    for (const PointFit& p : fit.points) {
        if (p.used && p.view == view) {
            seen[{p.column, p.row}][p.camera] = &p;
        }
    }
    std::vector<Twin> out;
    if (sights.seen[0] == nullptr) {
        return out;
    }
    for (const BoardPoint& point : sights.seen[0]->points) {
        const auto found = seen.find({point.column, point.row});
        if (found != seen.end() && found->second[0] != nullptr && found->second[1] != nullptr) {
            out.push_back({.left = {.at = found->second[0]->seen},
                           .right = {.at = found->second[1]->seen},
                           .board = point.place});
        }
    }
    return out;
}

void check_boards(const std::vector<BoardSights>& sights, const BoardFit& fit, StereoFit& out) {
    double squares = 0.0;
    double count = 0.0;
    for (std::size_t v = 0; v < sights.size(); ++v) {
        std::vector<PlacePair> pairs;
        for (const Twin& twin : twins_of(sights[v], fit, v)) {
            const double off = epipolar_distance(out.set, twin.left.at, twin.right.at);
            const auto place = triangulate(out.set, twin.left, twin.right);
            if (place) {
                squares += off * off;
                count += 1.0;
                pairs.push_back({.to = to_eigen(place->place), .from = to_eigen(twin.board)});
            }
        }
        if (!fit.views[v].used || pairs.size() < 4) {
            continue;
        }
        const Motion motion = fit_motion(pairs);
        Eigen::Vector3d middle_to = Eigen::Vector3d::Zero();
        Eigen::Vector3d middle_from = Eigen::Vector3d::Zero();
        for (const PlacePair& p : pairs) {
            middle_to += p.to / static_cast<double>(pairs.size());
            middle_from += p.from / static_cast<double>(pairs.size());
        }
        double sum = 0.0;
        double to = 0.0;
        double from = 0.0;
        for (const PlacePair& p : pairs) {
            sum += (p.to - motion * p.from).squaredNorm();
            to += (p.to - middle_to).squaredNorm();
            from += (p.from - middle_from).squaredNorm();
        }
        out.boards.push_back({.view = sights[v].name,
                              .points = pairs.size(),
                              .rms = std::sqrt(sum / static_cast<double>(pairs.size())),
                              .scale = std::sqrt(to / from) - 1.0});
    }
    out.epipolar_rms = count > 0.0 ? std::sqrt(squares / count) : 0.0;
}

/// At the median distance, in the middle of where the views lie.
ExpectedError expected_of(const std::vector<BoardSights>& sights, const BoardFit& fit, const CameraSet& set) {
    std::vector<double> x;
    std::vector<double> y;
    std::vector<double> z;
    for (std::size_t v = 0; v < sights.size(); ++v) {
        if (fit.views[v].used) {
            for (const BoardView* seen : sights[v].seen) {
                for (std::size_t i = 0; seen != nullptr && i < seen->points.size(); ++i) {
                    const Eigen::Vector3d p = fit.state.boards[v] * to_eigen(seen->points[i].place);
                    x.push_back(p[0]);
                    y.push_back(p[1]);
                    z.push_back(p[2]);
                }
            }
        }
    }
    const auto median = [](std::vector<double>& values) {
        const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::nth_element(values.begin(), middle, values.end());
        return *middle;
    };
    const Vec3 place{median(x), median(y), median(z)};
    ExpectedError out{.distance = place.z, .noise = {}, .calibration = {}};
    const auto left = project(set.cameras[0].model, place);
    const auto right = project(set.cameras[1].model, in_right(set, place));
    if (left && right) {
        const double variance = set.noise * set.noise;
        const std::array<double, 3> covariance{variance, 0.0, variance};
        if (const auto found = triangulate(set, {*left, covariance}, {*right, covariance})) {
            const auto sigma = [](const PlaceCovariance& c) {
                return Vec3{std::sqrt(c[0][0]), std::sqrt(c[1][1]), std::sqrt(c[2][2])};
            };
            out.noise = sigma(found->noise);
            out.calibration = sigma(found->calibration);
        }
    }
    return out;
}

void note_pairs(const Pairing& pairing, const BoardFit& fit, std::vector<std::string>& notes) {
    std::size_t common = 0;
    for (std::size_t v = 0; v < fit.views.size(); ++v) {
        const bool both = pairing.sights[v].seen[0] != nullptr && pairing.sights[v].seen[1] != nullptr;
        common += both && fit.views[v].used ? 1U : 0U;
        if (both && !fit.views[v].used) {
            notes.push_back(
                fmt::format("view {}: each picture fits by itself, left and right do not belong together; they "
                            "were not taken at one moment, or their board begins at another corner",
                            fit.views[v].name));
        }
    }
    if (common < kFewestCommon) {
        throw InputError(
            {.file = {},
             .problem = "too few views whose left and right picture belong together",
             .value = std::to_string(common),
             .action = "check the order of the lists: the first left picture belongs to the first right one"});
    }
}

}  // namespace

StereoFit fit_stereo(const std::filesystem::path& left_file, const std::vector<BoardView>& left,
                     const std::filesystem::path& right_file, const std::vector<BoardView>& right,
                     const CameraFitOptions& options) {
    const CameraFit left_fit = fit_camera(left_file, left, options);
    const CameraFit right_fit = fit_camera(right_file, right, options);
    const Pairing pairing = paired(left_file, left, right, left_fit, right_fit);
    StereoFit out;
    for (const CameraFit* fit : {&left_fit, &right_fit}) {
        const char* name = fit == &left_fit ? "left: " : "right: ";
        for (const std::string& note : fit->notes) {
            out.notes.push_back(name + note);
        }
        for (const ViewFit& view : fit->views) {
            if (!view.used) {
                out.notes.push_back(fmt::format("{}view {} is left out: {}", name, view.name, view.why));
            }
        }
    }
    const std::vector<FixedParameters> fixed{fixed_of(left_file, left_fit.camera.fixed),
                                             fixed_of(right_file, right_fit.camera.fixed)};
    const BoardState start{.cameras = {left_fit.camera.model, right_fit.camera.model},
                           .right_from_left = pairing.right_from_left,
                           .boards = pairing.boards};
    BoardFit fit = fit_boards(pairing.sights, start, fixed, {.find_wrong = options.find_wrong});
    note_pairs(pairing, fit, out.notes);
    out.set.cameras = {record_of(fit, 0, left_fit, fixed[0]), record_of(fit, 1, right_fit, fixed[1])};
    out.set.right_from_left = CameraSet::Pose{.rotation = to_mat(fit.state.right_from_left.r),
                                              .translation = to_vec(fit.state.right_from_left.t)};
    out.set.noise = fit.noise;
    take_covariance(fit, out);
    out.freedom = fit.freedom;
    const double n = 2.0 * static_cast<double>(std::ranges::count(fit.points, true, &PointFit::used));
    out.rms = std::sqrt(fit.chi_squared / n);
    check_boards(pairing.sights, fit, out);
    out.expected = expected_of(pairing.sights, fit, out.set);
    out.views = std::move(fit.views);
    out.wrong = std::move(fit.wrong);
    out.points = std::move(fit.points);
    return out;
}

}  // namespace sc::host
