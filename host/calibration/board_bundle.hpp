// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "host/calibration/bordered_system.hpp"
#include "host/calibration/motion.hpp"
#include "host/vision/camera.hpp"

/// Least squares over one or two cameras and the board's pose in each view. For camera_fit, stereo_fit, board_pose.

namespace sc::host {

/// One sight of one point.
struct BoardSight {
    std::size_t view = 0;
    std::size_t camera = 0;
    Eigen::Vector3d place;  ///< metres, on the board
    Eigen::Vector2d seen;   ///< px
    double weight = 1.0;    ///< 1/σ², in units of a common noise
};

/// Which parameters stay as they are.
using FixedParameters = std::array<bool, CameraModel::kParameters>;

struct BoardBundle {
    std::vector<BoardSight> sights;
    std::vector<FixedParameters> fixed;  ///< one a camera
};

struct BoardState {
    std::vector<CameraModel> cameras;  ///< one or two
    Motion right_from_left;
    std::vector<Motion> boards;  ///< left_from_board, one a view
};

using BoardSystem = BorderedSystem<6>;

/// Where the state has the sight; not finite behind the camera.
[[nodiscard]] Eigen::Vector2d predicted(const BoardState& state, const BoardSight& sight);
[[nodiscard]] double cost_of(const BoardBundle& bundle, const BoardState& state);
/// Minimises the weighted squares; returns their sum.
double refine(const BoardBundle& bundle, BoardState& state, int rounds = 40);
/// For a noise of 1 px. Common unknowns: nine of each camera, then the pair's turn (on the left) and place.
[[nodiscard]] BoardSystem::Spread spread_of(const BoardBundle& bundle, const BoardState& state);
[[nodiscard]] Eigen::Index common_size(std::size_t cameras);

/// A place on the board's plane and where it is seen on the plane z = 1.
struct PlanePair {
    Eigen::Vector2d board;
    Eigen::Vector2d seen;
};
/// seen ~ H (board, 1), from four pairs or more (normalised direct linear transform); none if they lie on a line.
[[nodiscard]] std::optional<Eigen::Matrix3d> homography_of(std::span<const PlanePair> pairs);
/// The same although some pairs are wrong: of 60 quadruples the one with the least median of distances, then all pairs
/// near it.
[[nodiscard]] std::optional<Eigen::Matrix3d> robust_homography(std::span<const PlanePair> pairs);
/// camera_from_board of a homography onto the plane z = 1; the board in front of the camera.
[[nodiscard]] Motion motion_of(const Eigen::Matrix3d& homography);

}  // namespace sc::host
