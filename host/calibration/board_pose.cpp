// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/board_pose.hpp"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "host/calibration/board_fit.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr std::size_t kFewestPoints = 6;
constexpr double kOther = std::numbers::pi / 180.0;  ///< turned by more: another pose
constexpr double kAlike = 1.3;                       ///< rms of the other pose over that of the better one
constexpr double kPoorPx = 0.5;
constexpr FixedParameters kAll{true, true, true, true, true, true, true, true, true};

/// The pose whose board is tilted the other way about the line of sight.
Motion mirrored(const Motion& pose, const Eigen::Vector3d& middle) {
    const Eigen::Vector3d at = pose * middle;
    const Eigen::Vector3d sight = at.normalized();
    const Eigen::Vector3d normal = pose.r.col(2);
    const Eigen::Vector3d axis = sight.cross(normal);
    if (!(axis.norm() > 1e-6)) {
        return pose;
    }
    const double angle = std::atan2(axis.norm(), std::abs(sight.dot(normal)));
    const double way = sight.dot(normal) > 0.0 ? -2.0 : 2.0;
    Motion out;
    out.r = exp_turn(way * angle * axis.normalized()) * pose.r;
    out.t = at - out.r * middle;
    return out;
}

struct Both {
    Motion best;
    double mirrored = 0.0;
};

Both solve_view(const BoardView& view, const Motion& start, const CameraModel& camera) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const BoardPoint& p : view.points) {
        middle += to_eigen(p.place) / static_cast<double>(view.points.size());
    }
    const std::vector<BoardSights> sights{{.name = view.name, .seen = {&view, nullptr}}};
    const auto fit = [&](const Motion& from) {
        return fit_boards(sights, {.cameras = {camera}, .right_from_left = {}, .boards = {from}}, {kAll},
                          {.find_wrong = false});
    };
    const BoardFit a = fit(start);
    const BoardFit b = fit(mirrored(a.state.boards[0], middle));
    const bool other = log_turn(a.state.boards[0].r * b.state.boards[0].r.transpose()).norm() > kOther;
    const bool b_is_best = b.chi_squared < a.chi_squared;
    return {.best = b_is_best ? b.state.boards[0] : a.state.boards[0],
            .mirrored = other ? rms_of(b_is_best ? a : b, 0) : 0.0};
}

}  // namespace

BoardPoses find_board_poses(const std::filesystem::path& file, const std::vector<BoardView>& views,
                            const CameraModel& camera, bool find_wrong) {
    BoardPoses out;
    std::vector<BoardSights> sights;
    std::vector<double> others;
    BoardState state{.cameras = {camera}, .right_from_left = {}, .boards = {}};
    for (const BoardView& view : views) {
        const auto start = view.points.size() >= kFewestPoints ? pose_by_homography(view, camera) : std::nullopt;
        if (!start) {
            out.notes.push_back(
                fmt::format("view {} is left out: its {} points give no pose; {} are needed, not on a line", view.name,
                            view.points.size(), kFewestPoints));
            continue;
        }
        const Both both = solve_view(view, *start, camera);
        sights.push_back({.name = view.name, .seen = {&view, nullptr}});
        state.boards.push_back(both.best);
        others.push_back(both.mirrored);
    }
    if (sights.empty()) {
        throw InputError({.file = file.string(),
                          .problem = "no view shows the board",
                          .value = std::to_string(views.size()) + " views",
                          .action = out.notes.empty() ? "give pictures of it" : out.notes.front()});
    }
    BoardFit fit = fit_boards(sights, state, {kAll}, {.find_wrong = find_wrong});
    out.noise = fit.noise;
    for (std::size_t v = 0; v < sights.size(); ++v) {
        const ViewFit& view = fit.views[v];
        if (!view.used) {
            out.notes.push_back(fmt::format("view {} is left out: {}", view.name, view.why));
            continue;
        }
        if (others[v] > 0.0 && others[v] < kAlike * view.rms[0]) {
            out.notes.push_back(
                fmt::format("view {}: tilted the other way the board fits nearly as well, {:.3f} px against "
                            "{:.3f} px; go nearer, or tilt it more",
                            view.name, others[v], view.rms[0]));
        }
        out.poses.push_back({.fit = view, .mirrored = others[v]});
    }
    if (out.noise > kPoorPx) {
        out.notes.push_back(
            fmt::format("residuals of {:.2f} px are the camera's, not the points': calibrate it "
                        "(scribecell calibrate camera)",
                        out.noise));
    }
    out.wrong = std::move(fit.wrong);
    return out;
}

}  // namespace sc::host
