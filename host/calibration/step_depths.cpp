// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/step_depths.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "host/calibration/transforms.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, std::string problem, std::string value,
                         std::string action) {
    throw InputError(
        {.file = file.string(), .problem = std::move(problem), .value = std::move(value), .action = std::move(action)});
}

std::optional<TargetStep> step_of(const Target& target, int marker) {
    for (const TargetStep& step : target.steps) {
        if (std::ranges::count(step.markers, marker) > 0) {
            return step;
        }
    }
    return std::nullopt;
}

}  // namespace

StepDepths fit_step_depths(const std::filesystem::path& file, const Target& target,
                           const std::vector<DepthReading>& readings, double focus_y) {
    const auto n = static_cast<Eigen::Index>(readings.size());
    if (n < 4) {
        refuse(file, "has too few markers for a plane", std::to_string(n), "measure four or more, on several steps");
    }
    const double y1 = focus_y;
    const double a1 = readings.front().distance;
    double mean_x = 0.0;
    double mean_z = 0.0;
    for (const DepthReading& r : readings) {
        mean_x += r.place.x / static_cast<double>(n);
        mean_z += r.place.z / static_cast<double>(n);
    }
    // Unknown: y at the middle, dy/dx, dy/dz, gain (per metre of difference).
    Eigen::MatrixXd a(n, 4);
    Eigen::VectorXd b(n);
    Eigen::VectorXd weight(n);
    double lowest = 1e9;
    double highest = -1e9;
    for (Eigen::Index i = 0; i < n; ++i) {
        const DepthReading& r = readings[static_cast<std::size_t>(i)];
        const auto step = step_of(target, r.marker);
        if (!step) {
            refuse(file, "a marker that is on no step of the target", std::to_string(r.marker),
                   "list it under a [[step]] of the target");
        }
        lowest = std::min(lowest, step->height);
        highest = std::max(highest, step->height);
        // The axes may stand elsewhere in y than at the first marker: the sensor rides with them.
        const double moved = r.place.y - readings.front().place.y;
        const double seen = depth_by_sensor(y1, a1, r.distance) + moved;
        a.row(i) << 1.0, r.place.x - mean_x, r.place.z - mean_z, -(a1 - r.distance);
        b(i) = seen - step->height;
        const double sigma = std::hypot(std::max(r.sigma, 1e-7), step->uncertainty);
        weight(i) = 1.0 / (sigma * sigma);
    }
    const bool steps = highest - lowest > 1e-3;
    const Eigen::Index unknowns = steps ? 4 : 3;
    const Eigen::MatrixXd used = a.leftCols(unknowns);
    const Eigen::MatrixXd normal = used.transpose() * weight.asDiagonal() * used;
    const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * normal * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
    if (!(eigen.eigenvalues()[0] > 1e-6)) {
        refuse(file, "the markers lie on a line: a tilt of the target across it is blind", fmt::format("{} markers", n),
               "measure markers beside the line too");
    }
    const Eigen::MatrixXd inverse = scale.asDiagonal() * scaled.inverse() * scale.asDiagonal();
    const Eigen::VectorXd x = inverse * (used.transpose() * weight.asDiagonal() * b);
    const Eigen::VectorXd left = b - used * x;
    StepDepths out;
    out.rms = std::sqrt(left.squaredNorm() / static_cast<double>(n));
    const double chi = left.dot(weight.asDiagonal() * left) / std::max(1.0, static_cast<double>(n - unknowns));
    const double raised = std::max(1.0, chi);
    out.tilt_x = x(1);
    out.tilt_z = x(2);
    out.gain = steps ? x(3) : 0.0;
    out.gain_sigma = steps ? std::sqrt(raised * inverse(3, 3)) : 0.0;
    for (Eigen::Index i = 0; i < n; ++i) {
        const DepthReading& r = readings[static_cast<std::size_t>(i)];
        Eigen::VectorXd of_plane = used.row(i).transpose();
        // What all have in common is the reading of the first marker; its noise is the sensor's, once.
        if (steps) {
            of_plane(3) = 0.0;
        }
        const double y = of_plane.dot(x) + step_of(target, r.marker)->height;
        out.depths.push_back({r.marker, y, std::sqrt(raised * of_plane.dot(inverse * of_plane)), left(i)});
    }
    return out;
}

}  // namespace sc::host
