// SPDX-License-Identifier: Apache-2.0
#include "host/path/plane.hpp"

#include <cmath>

#include <Eigen/Dense>

namespace sc::host {

namespace {
/// A spread below 1/200 of the other one is the scatter of points meant to be on a line, not a width to take a slope
/// from.
constexpr double kSmallestSpreadRatio = 5e-3;
}  // namespace

FacePlane fit_plane(std::span<const Vec3> points) {
    FacePlane plane;
    const double count = static_cast<double>(points.size());
    for (const Vec3& p : points) {
        plane.centroid = plane.centroid + (1.0 / count) * p;
    }
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    Eigen::Vector2d lean = Eigen::Vector2d::Zero();
    for (const Vec3& p : points) {
        const Eigen::Vector2d across(p.x - plane.centroid.x, p.z - plane.centroid.z);
        spread += across * across.transpose();
        lean += across * (p.y - plane.centroid.y);
    }
    // Along each principal direction of the points by itself, so that a direction without spread drops out alone.
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> principal(spread);
    const double largest = principal.eigenvalues()(1);
    Eigen::Vector2d slope = Eigen::Vector2d::Zero();
    for (Eigen::Index i = 0; i < 2; ++i) {
        const double value = principal.eigenvalues()(i);
        if (value > largest * kSmallestSpreadRatio * kSmallestSpreadRatio && value > 0.0) {
            const Eigen::Vector2d direction = principal.eigenvectors().col(i);
            slope += (direction.dot(lean) / value) * direction;
        }
    }
    plane.slope_x = slope.x();
    plane.slope_z = slope.y();
    double squares = 0.0;
    for (const Vec3& p : points) {
        const double off = p.y - plane.depth(p.x, p.z);
        squares += off * off;
    }
    plane.rms = std::sqrt(squares / count);
    return plane;
}

}  // namespace sc::host
