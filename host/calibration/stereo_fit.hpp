// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "host/calibration/camera_fit.hpp"

/// A pair of cameras from views of a flat board that both, or either, have seen: each camera by itself, then one bundle
/// over both cameras, the pose between them and the board's pose in each view. Host only; 9 views of 54 points take
/// some 60 ms.

namespace sc::host {

/// What a place at the working distance comes to with one pixel noise in each picture.
struct ExpectedError {
    double distance = 0.0;  ///< metres, of the median view
    Vec3 noise;             ///< 1 sigma along x, y, z of c by the pixels, metres; in the middle of the views
    Vec3 calibration;       ///< by the calibration's own uncertainty
};

/// A view triangulated and laid upon the board as it should be.
struct BoardCheck {
    std::string view;
    std::size_t points = 0;
    double rms = 0.0;    ///< metres, 3-D
    double scale = 0.0;  ///< measured over true distances, less 1
};

struct StereoFit {
    CameraSet set;  ///< id, time and parents are the caller's
    std::array<double, CameraModel::kParameters> left_sigma{};
    std::array<double, CameraModel::kParameters> right_sigma{};
    std::array<double, 6> pose_sigma{};  ///< turn on the left (rad), place (m)
    double baseline = 0.0;               ///< metres
    double baseline_sigma = 0.0;
    double rms = 0.0;           ///< px of a coordinate, both cameras
    double epipolar_rms = 0.0;  ///< px
    double freedom = 0.0;
    ExpectedError expected;
    std::vector<ViewFit> views;
    std::vector<WrongPoint> wrong;
    std::vector<PointFit> points;
    std::vector<BoardCheck> boards;
    std::vector<std::string> notes;
};

/// Views are paired by name. Throws InputError as fit_camera does for each camera (`left`, `right`: what messages
/// name), for fewer than three common views, and if no view has left and right that belong together.
[[nodiscard]] StereoFit fit_stereo(const std::filesystem::path& left_file, const std::vector<BoardView>& left,
                                   const std::filesystem::path& right_file, const std::vector<BoardView>& right,
                                   const CameraFitOptions& options = {});

}  // namespace sc::host
