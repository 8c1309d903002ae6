// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/camera_fit.hpp"

#include <cmath>

#include <fmt/format.h>

#include "host/calibration/camera_start.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr std::size_t kFewestViews = 3;
constexpr std::size_t kFewestPoints = 6;
constexpr int kMostFixed = 8;

void check(const std::filesystem::path& file, const std::vector<BoardView>& views) {
    for (const BoardView& view : views) {
        if (view.width <= 0 || view.height <= 0) {
            throw InputError({.file = file.string(),
                              .problem = "the size of the pictures is not known",
                              .value = view.name,
                              .action = "give --size WIDTHxHEIGHT"});
        }
        if (view.width != views.front().width || view.height != views.front().height) {
            throw InputError({.file = file.string(),
                              .problem = "pictures of different size",
                              .value = fmt::format("{}: {}x{}, {}: {}x{}", views.front().name, views.front().width,
                                                   views.front().height, view.name, view.width, view.height),
                              .action = "give the pictures of one camera"});
        }
    }
}

void refuse_few(const std::filesystem::path& file, std::size_t count, const std::string& of) {
    if (count < kFewestViews) {
        throw InputError({.file = file.string(),
                          .problem = "too few views for a camera" + of,
                          .value = std::to_string(count),
                          .action = "take 10 or more, tilted by 20 to 45 degrees, over the whole picture; 3 at least"});
    }
}

/// Focal length, poses and k1 first: the rest follows from there.
BoardState first_state(const std::vector<BoardSights>& sights, const std::vector<BoardView>& views,
                       const CameraFitOptions& options, const FixedParameters& asked) {
    BoardState state{.cameras = {start_camera(views, options.focal)}, .right_from_left = {}, .boards = {}};
    for (const BoardSights& view : sights) {
        state.boards.push_back(pose_by_homography(*view.seen[0], state.cameras[0]).value_or(Motion{}));
    }
    FixedParameters fixed{false, false, true, true, false, true, true, true, true};
    for (std::size_t k = 0; k < fixed.size(); ++k) {
        fixed[k] = fixed[k] || asked[k];
    }
    return fit_boards(sights, state, {fixed}, {}).state;
}

}  // namespace

CameraFit fit_camera(const std::filesystem::path& file, const std::vector<BoardView>& views,
                     const CameraFitOptions& options) {
    check(file, views);
    CameraFit out;
    std::vector<BoardView> usable;
    for (const BoardView& view : views) {
        if (view.points.size() >= kFewestPoints && pose_by_homography(view, {.focal_x = 1e3, .focal_y = 1e3})) {
            usable.push_back(view);
        } else {
            out.notes.push_back(
                fmt::format("view {} is left out: its {} points give no pose; {} are needed, not on a line", view.name,
                            view.points.size(), kFewestPoints));
        }
    }
    refuse_few(file, usable.size(), "");
    FixedParameters fixed = fixed_of(file, options.fixed);
    std::vector<BoardSights> sights;
    for (const BoardView& view : usable) {
        sights.push_back({.name = view.name, .seen = {&view, nullptr}});
    }
    out.camera.width = usable.front().width;
    out.camera.height = usable.front().height;
    const BoardState start = first_state(sights, usable, options, fixed);
    const BoardFitSettings settings{.find_wrong = options.find_wrong};
    BoardFit fit = fit_boards(sights, start, {fixed}, settings);
    for (int round = 0; round < kMostFixed && fix_blind(file, fit, 0, out.camera, options, fixed, out.notes); ++round) {
        fit = fit_boards(sights, start, {fixed}, settings);
    }
    std::size_t used = 0;
    for (const ViewFit& view : fit.views) {
        used += view.used ? 1U : 0U;
    }
    refuse_few(file, used, ": the others do not fit");
    note_views(fit, 0, out.camera, out.notes);
    out.camera.id = "camera";
    out.camera.model = fit.state.cameras[0];
    out.camera.fixed = names_of(fixed);
    out.camera.rms = rms_of(fit, 0);
    out.camera.reach = reach_of(fit, 0);
    constexpr std::size_t kNine = CameraModel::kParameters;
    out.covariance.assign(kNine, std::vector<double>(kNine));
    for (std::size_t i = 0; i < kNine; ++i) {
        for (std::size_t k = 0; k < kNine; ++k) {
            out.covariance[i][k] = fit.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
        }
        out.sigma[i] = std::sqrt(std::max(out.covariance[i][i], 0.0));
    }
    out.noise = fit.noise;
    out.freedom = fit.freedom;
    out.views = std::move(fit.views);
    out.wrong = std::move(fit.wrong);
    out.points = std::move(fit.points);
    return out;
}

}  // namespace sc::host
