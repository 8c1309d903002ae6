// SPDX-License-Identifier: Apache-2.0
#include "host/verification/error_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>

namespace sc::host {

namespace {

constexpr double kLeastSpread = 10e-3;
constexpr std::size_t kFewestForSlopes = 4;

/// Coefficients of 1, x, z for one component of the error, with their covariance.
struct Fitted {
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    [[nodiscard]] double sigma(Eigen::Index i) const { return std::sqrt(std::max(0.0, covariance(i, i))); }
};

bool shows_slopes(std::span<const ErrorSample> samples) {
    const auto spread = [&](double Vec3::* member) {
        const auto [least, most] = std::ranges::minmax_element(
            samples, {}, [member](const ErrorSample& sample) { return sample.commanded.*member; });
        return most->commanded.*member - least->commanded.*member;
    };
    return samples.size() >= kFewestForSlopes && spread(&Vec3::x) >= kLeastSpread && spread(&Vec3::z) >= kLeastSpread;
}

Fitted fit(const Eigen::MatrixXd& design, const Eigen::VectorXd& error) {
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(design);
    const Eigen::VectorXd solution = qr.solve(error);
    const Eigen::Index unknowns = design.cols();
    const double squares = (error - design * solution).squaredNorm();
    const auto freedom = static_cast<double>(std::max<Eigen::Index>(1, design.rows() - unknowns));
    const Eigen::MatrixXd inverse = (design.transpose() * design).inverse();
    Fitted out;
    out.value.head(unknowns) = solution;
    out.covariance.topLeftCorner(unknowns, unknowns) = (squares / freedom) * inverse;
    return out;
}

void name_errors(const std::array<Fitted, 3>& xyz, bool slopes, ErrorFit& out) {
    const Fitted& x = xyz[0];
    const Fitted& y = xyz[1];
    const Fitted& z = xyz[2];
    const auto offset = [&out](std::string_view name, const Fitted& f) {
        out.errors.push_back({name, 1e6 * f.value(0), 1e6 * f.sigma(0), "um"});
    };
    offset("offset_x", x);
    offset("offset_y", y);
    offset("offset_z", z);
    if (!slopes) {
        return;
    }
    out.errors.push_back({"rotation", 1e3 * z.value(1), 1e3 * z.sigma(1), "mrad"});
    out.errors.push_back(
        {"squareness_xz", 1e3 * (x.value(2) + z.value(1)), 1e3 * std::hypot(x.sigma(2), z.sigma(1)), "mrad"});
    out.errors.push_back({"squareness_yz", 1e3 * y.value(2), 1e3 * y.sigma(2), "mrad"});
    out.errors.push_back({"tilt_yx", 1e3 * y.value(1), 1e3 * y.sigma(1), "mrad"});
    out.errors.push_back({"scale_x", 1e6 * x.value(1), 1e6 * x.sigma(1), "ppm"});
    out.errors.push_back({"scale_z", 1e6 * z.value(2), 1e6 * z.sigma(2), "ppm"});
}

}  // namespace

ErrorFit fit_errors(std::span<const ErrorSample> samples) {
    ErrorFit out;
    if (samples.empty()) {
        return out;
    }
    const bool slopes = shows_slopes(samples);
    const auto rows = static_cast<Eigen::Index>(samples.size());
    Eigen::MatrixXd design(rows, slopes ? 3 : 1);
    Eigen::MatrixX3d error(rows, 3);
    Eigen::Index row = 0;
    for (const ErrorSample& sample : samples) {
        design(row, 0) = 1.0;
        if (slopes) {
            design(row, 1) = sample.commanded.x;
            design(row, 2) = sample.commanded.z;
        }
        const Vec3 off = sample.found - sample.commanded;
        error.row(row) << off.x, off.y, off.z;
        ++row;
    }
    std::array<Fitted, 3> xyz;
    Eigen::MatrixX3d left = error;
    for (Eigen::Index i = 0; i < 3; ++i) {
        Fitted& component = xyz[static_cast<std::size_t>(i)];
        component = fit(design, error.col(i));
        left.col(i) -= design * component.value.head(design.cols());
    }
    name_errors(xyz, slopes, out);
    out.rms_um = 1e6 * std::sqrt(left.rowwise().squaredNorm().mean());
    out.worst_um = 1e6 * left.rowwise().norm().maxCoeff();
    return out;
}

}  // namespace sc::host
