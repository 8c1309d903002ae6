// SPDX-License-Identifier: Apache-2.0
#include "host/vision/triangulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

namespace sc::host {
namespace {

constexpr int kRounds = 20;
constexpr double kParallel = 1e-6;  ///< sine of the angle between two rays
constexpr Eigen::Index kNine = static_cast<Eigen::Index>(CameraModel::kParameters);

using Vector3 = Eigen::Vector3d;
using Slopes = Eigen::Matrix<double, 4, 3>;
using CalibrationSlopes = Eigen::Matrix<double, 4, 2 * kNine + 6>;

Vector3 vector_of(const Vec3& v) { return {v.x, v.y, v.z}; }

Eigen::Matrix3d matrix_of(const Mat3& m) {
    Eigen::Matrix3d out;
    out << m.row[0].x, m.row[0].y, m.row[0].z, m.row[1].x, m.row[1].y, m.row[1].z, m.row[2].x, m.row[2].y, m.row[2].z;
    return out;
}

PlaceCovariance rows_of(const Eigen::Matrix3d& m) {
    PlaceCovariance out{};
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            out[i][k] = m(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
        }
    }
    return out;
}

Eigen::Matrix2d weight_of(const std::array<double, 3>& c) {
    Eigen::Matrix2d m;
    m << c[0], c[1], c[1], c[2];
    return m.inverse();
}

/// What the pair sees of a place, and how that changes.
struct Sight {
    Eigen::Vector4d at;
    Slopes by_place;
    CalibrationSlopes by_calibration;
};

std::optional<Sight> sight_of(const CameraSet& pair, const Vector3& place) {
    const Eigen::Matrix3d turn = matrix_of(pair.right_from_left->rotation);
    const Vector3 turned = turn * place;
    const Vector3 right = turned + vector_of(pair.right_from_left->translation);
    const auto l = project_with_slopes(pair.cameras[0].model, {place[0], place[1], place[2]});
    const auto r = project_with_slopes(pair.cameras[1].model, {right[0], right[1], right[2]});
    if (!l || !r) {
        return std::nullopt;
    }
    Sight out;
    out.by_calibration.setZero();
    Eigen::Matrix<double, 2, 3> in_right;
    for (Eigen::Index i = 0; i < 2; ++i) {
        const auto row = static_cast<std::size_t>(i);
        out.at[i] = l->at[row];
        out.at[2 + i] = r->at[row];
        for (std::size_t k = 0; k < 3; ++k) {
            out.by_place(i, static_cast<Eigen::Index>(k)) = l->by_place[row][k];
            in_right(i, static_cast<Eigen::Index>(k)) = r->by_place[row][k];
        }
        for (std::size_t k = 0; k < CameraModel::kParameters; ++k) {
            out.by_calibration(i, static_cast<Eigen::Index>(k)) = l->by_camera[row][k];
            out.by_calibration(2 + i, kNine + static_cast<Eigen::Index>(k)) = r->by_camera[row][k];
        }
    }
    out.by_place.bottomRows<2>() = in_right * turn;
    Eigen::Matrix3d cross;
    cross << 0.0, -turned[2], turned[1], turned[2], 0.0, -turned[0], -turned[1], turned[0], 0.0;
    out.by_calibration.block<2, 3>(2, 2 * kNine) = -in_right * cross;
    out.by_calibration.block<2, 3>(2, 2 * kNine + 3) = in_right;
    return out;
}

/// Nearest to both rays; none if they are parallel.
std::optional<Vector3> middle_of_rays(const CameraSet& pair, const Ray& left, const Ray& right) {
    const Eigen::Matrix3d turn = matrix_of(pair.right_from_left->rotation);
    const Vector3 a(left.x, left.y, 1.0);
    const Vector3 b = turn.transpose() * Vector3(right.x, right.y, 1.0);
    const Vector3 from = -(turn.transpose() * vector_of(pair.right_from_left->translation));
    const Vector3 across = a.cross(b);
    if (!(across.norm() > kParallel * a.norm() * b.norm())) {
        return std::nullopt;
    }
    Eigen::Matrix<double, 3, 2> rays;
    rays << a, -b;
    const Eigen::Vector2d way = rays.colPivHouseholderQr().solve(from);
    return Vector3(0.5 * (way[0] * a + from + way[1] * b));
}

std::unexpected<std::string> refused(const char* text) { return std::unexpected(std::string(text)); }

/// From the line in the right picture to the right ray, on the plane z = 1.
double off_line(const CameraSet& pair, const Ray& left, const Ray& right) {
    const Vector3 t = vector_of(pair.right_from_left->translation);
    const Vector3 line = t.cross(matrix_of(pair.right_from_left->rotation) * Vector3(left.x, left.y, 1.0));
    return line.dot(Vector3(right.x, right.y, 1.0)) / std::hypot(line[0], line[1]);
}

}  // namespace

Vec3 Triangulated::sigma() const {
    const auto along = [&](std::size_t k) { return std::sqrt(std::max(noise[k][k] + calibration[k][k], 0.0)); };
    return {along(0), along(1), along(2)};
}

Vec3 in_right(const CameraSet& pair, const Vec3& place) {
    return pair.right_from_left->rotation * place + pair.right_from_left->translation;
}

double epipolar_distance(const CameraSet& pair, const Pixel& left, const Pixel& right) {
    const auto l = undistorted(pair.cameras[0].model, left);
    const auto r = undistorted(pair.cameras[1].model, right);
    if (!l || !r) {
        return std::numeric_limits<double>::quiet_NaN();
    }
    return off_line(pair, *l, *r) * std::sqrt(pair.cameras[1].model.focal_x * pair.cameras[1].model.focal_y);
}

std::expected<Triangulated, std::string> triangulate(const CameraSet& pair, const SeenPoint& left,
                                                     const SeenPoint& right) {
    const auto l = undistorted(pair.cameras[0].model, left.at);
    const auto r = undistorted(pair.cameras[1].model, right.at);
    if (!l || !r) {
        return refused("the camera's model does not reach this pixel");
    }
    const auto start = middle_of_rays(pair, *l, *r);
    if (!start) {
        return refused("the rays are parallel: the place is too far away, or the two points are not one");
    }
    Vector3 place = *start;
    Eigen::Matrix4d weight = Eigen::Matrix4d::Zero();
    weight.topLeftCorner<2, 2>() = weight_of(left.covariance);
    weight.bottomRightCorner<2, 2>() = weight_of(right.covariance);
    const Eigen::Vector4d seen(left.at[0], left.at[1], right.at[0], right.at[1]);
    Eigen::Vector4d residual = Eigen::Vector4d::Zero();
    Eigen::Matrix<double, 3, 4> gain = Eigen::Matrix<double, 3, 4>::Zero();
    std::optional<Sight> sight;
    for (int round = 0; round < kRounds; ++round) {
        sight = sight_of(pair, place);
        if (!sight) {
            return refused("the rays meet behind a camera: the two points are not one");
        }
        residual = seen - sight->at;
        const Eigen::Matrix<double, 3, 4> pull = sight->by_place.transpose() * weight;
        gain = (pull * sight->by_place).inverse() * pull;
        const Vector3 step = gain * residual;
        place += step;
        if (step.norm() < 1e-12 * place.norm()) {
            break;
        }
    }
    if (!place.allFinite() || !(place[2] > 0.0)) {
        return refused("the rays meet behind a camera: the two points are not one");
    }
    Triangulated out{.place = {place[0], place[1], place[2]}};
    out.noise = rows_of(gain * weight.inverse() * gain.transpose());
    if (!pair.covariance.empty()) {
        Eigen::MatrixXd spread(2 * kNine + 6, 2 * kNine + 6);
        for (Eigen::Index i = 0; i < spread.rows(); ++i) {
            for (Eigen::Index k = 0; k < spread.cols(); ++k) {
                spread(i, k) = pair.covariance[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
            }
        }
        const Eigen::Matrix<double, 3, 2 * kNine + 6> by = gain * sight->by_calibration;
        out.calibration = rows_of(by * spread * by.transpose());
    }
    out.epipolar = off_line(pair, *l, *r) * std::sqrt(pair.cameras[1].model.focal_x * pair.cameras[1].model.focal_y);
    out.surprise = residual.dot(weight * residual);
    return out;
}

}  // namespace sc::host
