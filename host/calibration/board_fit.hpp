// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/calibration/board_bundle.hpp"
#include "host/calibration/board_views.hpp"

/// The robust fit that cameras, pairs and single poses share. For camera_fit, stereo_fit and board_pose.

namespace sc::host {

/// What each camera saw in a view; null where it saw nothing.
struct BoardSights {
    std::string name;
    std::array<const BoardView*, 2> seen{};
};

struct BoardFitSettings {
    bool find_wrong = true;
    double outlier = 6.0;          ///< robust standard deviations
    double most_wrong = 0.4;       ///< share of a picture's points: beyond, the picture is bad
    double bad_view = 3.0;         ///< rms of a picture over the others'
    double least_noise_px = 0.02;  ///< what is nearer is never wrong
};

struct BoardFit {
    BoardState state;
    Eigen::MatrixXd covariance;  ///< of the common unknowns
    double noise = 0.0;          ///< px: 1 sigma of a coordinate
    double chi_squared = 0.0;    ///< px²
    double freedom = 0.0;
    std::vector<ViewFit> views;  ///< as many as `sights`
    std::vector<WrongPoint> wrong;
    std::vector<PointFit> points;
};

/// From `start` (a pose for each view) by Geman and McClure's weights, then plain least squares without what is wrong.
[[nodiscard]] BoardFit fit_boards(const std::vector<BoardSights>& sights, const BoardState& start,
                                  const std::vector<FixedParameters>& fixed, const BoardFitSettings& settings);

/// left_from_board by a homography of what a picture shows, as the camera undistorts it; none without four points.
[[nodiscard]] std::optional<Motion> pose_by_homography(const BoardView& view, const CameraModel& camera);
/// 1 sigma of a coordinate of each camera over the points that count.
[[nodiscard]] double rms_of(const BoardFit& fit, std::size_t camera);

}  // namespace sc::host
