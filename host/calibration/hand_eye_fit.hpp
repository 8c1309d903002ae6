// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/calibration/bordered_system.hpp"
#include "host/calibration/motion.hpp"

/// The parts of hand-eye calibration: the closed form and the maximum-likelihood fit. For hand_eye.cpp.

namespace sc::host {

/// A marker that a view saw.
struct HandEyeSight {
    int view = 0;
    int marker = 0;
    Eigen::Vector3d place;   ///< in c
    Eigen::Vector3d weight;  ///< 1/σ² of its coordinates
};
struct HandEyeProblem {
    std::vector<Motion> read;  ///< robot poses, b_from_f
    std::vector<HandEyeSight> sights;
    int markers = 0;
    double turn_sigma = 0.0;  ///< of a robot pose
    double place_sigma = 0.0;
};
struct HandEyeState {
    Motion x;                         ///< f_from_c
    std::vector<Motion> robot;        ///< what the poses truly were
    std::vector<Eigen::Vector3d> at;  ///< markers in b
};
using HandEyeSystem = BorderedSystem<6>;
struct HandEyeFit {
    HandEyeState state;
    double chi_squared = 0.0;
    HandEyeSystem::Spread spread;  ///< common: turn of X (left), place of X, then markers; own: turn, place of a pose
};

/// From X alone: poses as read, markers where the views see them on average.
[[nodiscard]] HandEyeState start_state(const HandEyeProblem& problem, const Motion& x);
[[nodiscard]] HandEyeFit fit_hand_eye(const HandEyeProblem& problem, const HandEyeState& start);
/// Measured less predicted, metres.
[[nodiscard]] Eigen::Vector3d sight_residual(const HandEyeState& state, const HandEyeSight& sight);
/// Turn and place by which a robot pose was moved.
[[nodiscard]] Eigen::Matrix<double, 6, 1> pose_change(const Motion& read, const Motion& now);

/// Closed form.
struct HandEyeStart {
    Motion x;
    double scatter = 0.0;          ///< metres rms: place of the target in b, view to view, with 0.2 m of its turn
    Eigen::Vector3d turned;        ///< singular values of the axial vectors of the robot's motions, rms; falling
    Eigen::Matrix3d turned_about;  ///< their directions in f, columns
};
/// `f`: b_from_f, `c`: c_from_g of the same views, three or more.
[[nodiscard]] HandEyeStart start_hand_eye(const std::vector<Motion>& f, const std::vector<Motion>& c);
/// Rms difference, radians, between the angles of the robot's motions and of the target's, with the target's views
/// taken `shift` rows later.
[[nodiscard]] double angle_mismatch(const std::vector<Motion>& f, const std::vector<Motion>& c, int shift);
/// Views whose angles disagree with those of most others by more than `limit` radians.
[[nodiscard]] std::vector<bool> out_of_step(const std::vector<Motion>& f, const std::vector<Motion>& c, double limit);

}  // namespace sc::host
