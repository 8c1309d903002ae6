// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "host/calibration/board_views.hpp"
#include "host/formats/cameras.hpp"

/// One camera from views of a flat board: homographies give the focal length and the poses in closed form (Z. Zhang, "A
/// flexible new technique for camera calibration", IEEE PAMI 22 (2000), square pixels, the middle of the picture), then
/// maximum likelihood over all nine parameters and poses. Host only; 9 views of 54 points take some 20 ms.

namespace sc::host {

struct CameraFitOptions {
    bool find_wrong = true;           ///< leave out points and pictures that do not fit, and name them
    std::vector<std::string> fixed;   ///< parameters that stay: distortion 0, the middle of the picture; fx, fy
    double focal = 0.0;               ///< px; the start, and what fx and fy stay at
    double most_focal_sigma = 0.03;   ///< of the focal length: beyond, the views cannot show it
    double most_middle_sigma = 0.05;  ///< of the picture's width: beyond, the middle stays the picture's
    double most_edge_sigma_px = 2.0;  ///< what a blind distortion may move the outermost point
};

struct CameraFit {
    CameraRecord camera;
    std::array<double, CameraModel::kParameters> sigma{};  ///< 0: fixed
    std::vector<std::vector<double>> covariance;           ///< 9 × 9
    double noise = 0.0;                                    ///< px: 1 sigma of a coordinate
    double freedom = 0.0;
    std::vector<ViewFit> views;
    std::vector<WrongPoint> wrong;
    std::vector<PointFit> points;
    std::vector<std::string> notes;  ///< sentences: what was fixed and why, what the views lack
};

/// `file`: what messages name. Throws InputError for fewer than three views that fit, views without a size, and views
/// that cannot show the focal length (all parallel to the picture plane), with what to do.
[[nodiscard]] CameraFit fit_camera(const std::filesystem::path& file, const std::vector<BoardView>& views,
                                   const CameraFitOptions& options = {});

}  // namespace sc::host
