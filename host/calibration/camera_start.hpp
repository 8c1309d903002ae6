// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/calibration/board_fit.hpp"
#include "host/calibration/camera_fit.hpp"

/// What camera_fit and stereo_fit share.

namespace sc::host {

[[nodiscard]] FixedParameters fixed_of(const std::filesystem::path& file, const std::vector<std::string>& names);
[[nodiscard]] std::vector<std::string> names_of(const FixedParameters& fixed);
/// Closed form: square pixels, no distortion, the middle of the picture.
[[nodiscard]] CameraModel start_camera(const std::vector<BoardView>& views, double focal);
/// Fixes what the data cannot tell, and says so. True if something was fixed. Throws InputError if it is the focal
/// length.
[[nodiscard]] bool fix_blind(const std::filesystem::path& file, const BoardFit& fit, std::size_t camera,
                             const CameraRecord& record, const CameraFitOptions& options, FixedParameters& fixed,
                             std::vector<std::string>& notes);
/// What the views lack: distances, share of the picture.
void note_views(const BoardFit& fit, std::size_t camera, const CameraRecord& record, std::vector<std::string>& notes);
/// Largest undistorted r of the points that count.
[[nodiscard]] double reach_of(const BoardFit& fit, std::size_t camera);
[[nodiscard]] double focal_of(const CameraModel& camera);

}  // namespace sc::host
