// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <Eigen/Dense>

#include "shared/geometry/vec.hpp"

/// Rigid motions for the estimators of this folder and of host/registration, in Eigen's types.

namespace sc::host {

/// p_to = r p_from + t, metres.
struct Motion {
    Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
    Eigen::Vector3d t = Eigen::Vector3d::Zero();

    [[nodiscard]] Motion inverse() const { return {r.transpose(), -(r.transpose() * t)}; }
    [[nodiscard]] Motion operator*(const Motion& b) const { return {r * b.r, r * b.t + t}; }
    [[nodiscard]] Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return r * p + t; }
};

[[nodiscard]] inline Eigen::Vector3d to_eigen(const Vec3& v) { return {v.x, v.y, v.z}; }
[[nodiscard]] inline Vec3 to_vec(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }
[[nodiscard]] Eigen::Matrix3d to_eigen(const Mat3& m);
[[nodiscard]] Mat3 to_mat(const Eigen::Matrix3d& m);

/// [v]×: skew(a)·b = a × b.
[[nodiscard]] Eigen::Matrix3d skew(const Eigen::Vector3d& v);
/// Rotation of |w| radians about w.
[[nodiscard]] Eigen::Matrix3d exp_turn(const Eigen::Vector3d& w);
/// Its inverse: rotation vector of 0 to π; at π the sign of the axis is arbitrary.
[[nodiscard]] Eigen::Vector3d log_turn(const Eigen::Matrix3d& r);
/// 2 sin(angle)·axis: turns with the frame as a rotation vector does, and has no jump at a half turn.
[[nodiscard]] Eigen::Vector3d axial(const Eigen::Matrix3d& r);

/// Rotation that brings `b` nearest to `a` (sum of |a − R b|²), from Σ a bᵀ.
[[nodiscard]] Eigen::Matrix3d nearest_turn(const Eigen::Matrix3d& a_bt);

/// A place in two frames, and what it counts for.
struct PlacePair {
    Eigen::Vector3d to;
    Eigen::Vector3d from;
    double weight = 1.0;
};
/// Closed-form rigid fit (Arun, Umeyama). `pairs` must be three or more, not on a line.
[[nodiscard]] Motion fit_motion(std::span<const PlacePair> pairs);

/// x such that chi-squared with k degrees of freedom exceeds it with probability `tail` (Wilson and Hilferty: within
/// 1 % for tails of 1e-9 and more, k >= 2). For limits alone.
[[nodiscard]] double chi_squared_limit(double k, double tail);

}  // namespace sc::host
