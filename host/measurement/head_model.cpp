// SPDX-License-Identifier: Apache-2.0
#include "host/measurement/head_model.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace sc::host {

namespace {

constexpr int kPlaneRounds = 6;
constexpr std::size_t kPerRay = 6;
constexpr double kReadingStep = 1e-6;                                     ///< metres
constexpr std::array kParameterStep{1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6};  ///< metres and radians

Vec3 direction_of(const TripleRay& ray) {
    const Vec3 v{ray.tilt[0], ray.tilt[1], 1.0};
    return (1.0 / norm(v)) * v;
}

struct Beam {
    Vec3 origin;
    Vec3 direction;
};

Beam beam_of(const TripleRay& ray, const HeadPose& pose) {
    const Mat3 turn = tilt_matrix(pose.tilt);
    return {pose.shift + turn * Vec3{ray.origin[0], ray.origin[1], 0.0}, turn * direction_of(ray)};
}

double along(const TripleRay& ray, double value) { return (1.0 + ray.gain) * (value - ray.zero); }

/// How much faster than z − a1 x − a2 y grows the way along the beam.
double slope(const DevicePlane& plane, const Vec3& direction) {
    return direction.z - plane.a[1] * direction.x - plane.a[2] * direction.y;
}

}  // namespace

Vec3 DevicePlane::normal() const noexcept {
    const Vec3 v{a[1], a[2], -1.0};
    return (1.0 / norm(v)) * v;
}

double DevicePlane::incidence() const noexcept { return std::atan(std::hypot(a[1], a[2])); }

Mat3 rotation_exp(const Vec3& w) {
    const double angle = norm(w);
    if (angle < 1e-15) {
        return {{Vec3{1.0, -w.z, w.y}, Vec3{w.z, 1.0, -w.x}, Vec3{-w.y, w.x, 1.0}}};
    }
    const Vec3 u = (1.0 / angle) * w;
    const double s = std::sin(angle);
    const double c = std::cos(angle);
    const double k = 1.0 - c;
    return {{Vec3{c + u.x * u.x * k, u.x * u.y * k - u.z * s, u.x * u.z * k + u.y * s},
             Vec3{u.y * u.x * k + u.z * s, c + u.y * u.y * k, u.y * u.z * k - u.x * s},
             Vec3{u.z * u.x * k - u.y * s, u.z * u.y * k + u.x * s, c + u.z * u.z * k}}};
}

Mat3 tilt_matrix(const Vec3& tilt) {
    return rotation_exp({0.0, 0.0, tilt.z}) * rotation_exp({0.0, tilt.y, 0.0}) * rotation_exp({tilt.x, 0.0, 0.0});
}

TripleRecord changed(const TripleRecord& record, const HeadVector& change) {
    TripleRecord out = record;
    for (std::size_t i = 0; i < out.rays.size(); ++i) {
        TripleRay& ray = out.rays[i];
        const auto at = [&](std::size_t k) { return change(static_cast<int>(kPerRay * i + k)); };
        ray.origin[0] += at(0);
        ray.origin[1] += at(1);
        ray.tilt[0] += at(2);
        ray.tilt[1] += at(3);
        ray.zero += at(4);
        ray.gain += at(5);
    }
    if (out.reference) {
        const Mat3 turn = rotation_exp({change(18), change(19), change(20)});
        out.reference->rotation = turn * out.reference->rotation;
        out.reference->translation = turn * out.reference->translation + Vec3{change(21), change(22), change(23)};
    }
    return out;
}

HeadMatrix covariance_of(const TripleRecord& record) {
    HeadMatrix out;
    for (std::size_t i = 0; i < kHeadParameters; ++i) {
        for (std::size_t j = 0; j < kHeadParameters; ++j) {
            out(static_cast<int>(i), static_cast<int>(j)) = record.covariance.at[i][j];
        }
    }
    return out;
}

void set_covariance(TripleRecord& record, const HeadMatrix& covariance) {
    for (std::size_t i = 0; i < kHeadParameters; ++i) {
        for (std::size_t j = 0; j < kHeadParameters; ++j) {
            record.covariance.at[i][j] = 0.5 * (covariance(static_cast<int>(i), static_cast<int>(j)) +
                                                covariance(static_cast<int>(j), static_cast<int>(i)));
        }
    }
}

Vec3 spot_of(const TripleRay& ray, double value, const HeadPose& pose) {
    const Beam beam = beam_of(ray, pose);
    return beam.origin + along(ray, value) * beam.direction;
}

DevicePlane fit_plane(const TripleRecord& record, const std::vector<PoseReadings>& readings) {
    DevicePlane plane;
    for (int round = 0; round < kPlaneRounds; ++round) {
        Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
        Eigen::Vector3d right = Eigen::Vector3d::Zero();
        for (const PoseReadings& reading : readings) {
            for (std::size_t i = 0; i < record.rays.size(); ++i) {
                const Beam beam = beam_of(record.rays[i], reading.pose);
                const Vec3 p = beam.origin + along(record.rays[i], reading.value[i]) * beam.direction;
                // Sensors err along the beam: a residual in z counts by how steeply the beam meets the plane.
                const double weight = 1.0 / (reading.sigma[i] * slope(plane, beam.direction));
                const Eigen::Vector3d row = weight * Eigen::Vector3d(1.0, p.x, p.y);
                normal += row * row.transpose();
                right += weight * p.z * row;
            }
        }
        const Eigen::Vector3d a = normal.ldlt().solve(right);
        plane.a = {a(0), a(1), a(2)};
    }
    return plane;
}

double plane_misfit(const TripleRecord& record, const std::vector<PoseReadings>& readings, const DevicePlane& plane) {
    double sum = 0.0;
    for (const PoseReadings& reading : readings) {
        for (std::size_t i = 0; i < record.rays.size(); ++i) {
            const Beam beam = beam_of(record.rays[i], reading.pose);
            const Vec3 p = beam.origin + along(record.rays[i], reading.value[i]) * beam.direction;
            const double over = (p.z - plane.a[0] - plane.a[1] * p.x - plane.a[2] * p.y) /
                                (slope(plane, beam.direction) * reading.sigma[i]);
            sum += over * over;
        }
    }
    return sum;
}

std::array<double, 2> spot_spread(const TripleRecord& record, const std::vector<PoseReadings>& readings) {
    std::vector<Eigen::Vector2d> places;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const PoseReadings& reading : readings) {
        for (std::size_t i = 0; i < record.rays.size(); ++i) {
            const Vec3 p = spot_of(record.rays[i], reading.value[i], reading.pose);
            places.emplace_back(p.x, p.y);
            mean += places.back();
        }
    }
    mean /= static_cast<double>(places.size());
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    for (const Eigen::Vector2d& p : places) {
        scatter += (p - mean) * (p - mean).transpose();
    }
    scatter /= static_cast<double>(places.size());
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(scatter, Eigen::EigenvaluesOnly);
    return {std::sqrt(std::max(0.0, solver.eigenvalues()(1))), std::sqrt(std::max(0.0, solver.eigenvalues()(0)))};
}

Vec3 to_reference(const TripleReference& reference, const Vec3& place_d) {
    return reference.rotation.transposed() * (place_d - reference.translation);
}

Vec3 direction_to_reference(const TripleReference& reference, const Vec3& direction_d) {
    return reference.rotation.transposed() * direction_d;
}

PlaneFigures figures_of(const TripleReference& reference, const DevicePlane& plane, const std::array<double, 2>& at) {
    const Vec3 n = direction_to_reference(reference, plane.normal());
    const Vec3 p = to_reference(reference, {0.0, 0.0, plane.a[0]});
    PlaneFigures out;
    // Equation 10 of the paper, pi − arccos(n1·n2), with both normals oriented; atan2 keeps its digits near 0 and pi.
    out.angle = std::numbers::pi - std::atan2(std::hypot(n.x, n.y), n.z);
    out.about_y = 0.5 * std::numbers::pi + std::atan2(n.z, -n.x);
    out.about_z = std::atan2(-n.y, -n.x);
    out.distance = (dot(n, p) - n.y * at[0] - n.z * at[1]) / n.x;
    return out;
}

FigureSensitivity sensitivity(const TripleRecord& record, const std::vector<PoseReadings>& readings,
                              const std::array<double, 2>& at) {
    const auto figures = [&](const TripleRecord& model, const std::vector<PoseReadings>& values) {
        return figures_of(*model.reference, fit_plane(model, values), at).vector();
    };
    FigureSensitivity out;
    out.by_reading.resize(4, static_cast<int>(3 * readings.size()));
    for (std::size_t k = 0; k < readings.size(); ++k) {
        for (std::size_t i = 0; i < 3; ++i) {
            std::vector<PoseReadings> up = readings;
            std::vector<PoseReadings> down = readings;
            up[k].value[i] += kReadingStep;
            down[k].value[i] -= kReadingStep;
            out.by_reading.col(static_cast<int>(3 * k + i)) =
                (figures(record, up) - figures(record, down)) / (2.0 * kReadingStep);
        }
    }
    for (std::size_t j = 0; j < kHeadParameters; ++j) {
        const double step = kParameterStep[j % kParameterStep.size()];
        HeadVector change = HeadVector::Zero();
        change(static_cast<int>(j)) = step;
        out.by_parameter.col(static_cast<int>(j)) =
            (figures(changed(record, change), readings) - figures(changed(record, -change), readings)) / (2.0 * step);
    }
    return out;
}

}  // namespace sc::host
