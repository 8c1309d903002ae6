// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/calibration/board_views.hpp"
#include "host/formats/cameras.hpp"

/// Where a flat board stands before a known camera: a homography, then least squares, robust, with covariance.

namespace sc::host {

struct BoardPose {
    ViewFit fit;            ///< camera_from_board, 1 sigma, rms
    double mirrored = 0.0;  ///< px: rms of the other pose that a small or far board may be taken for; 0: there is none
};

struct BoardPoses {
    std::vector<BoardPose> poses;  ///< of the views that have one
    std::vector<WrongPoint> wrong;
    double noise = 0.0;  ///< px: 1 sigma of a coordinate, over all views
    std::vector<std::string> notes;
};

/// `file`: what messages name. Throws InputError if no view gives a pose.
[[nodiscard]] BoardPoses find_board_poses(const std::filesystem::path& file, const std::vector<BoardView>& views,
                                          const CameraModel& camera, bool find_wrong = true);

}  // namespace sc::host
