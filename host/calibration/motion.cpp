// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/motion.hpp"

#include <algorithm>
#include <cmath>

namespace sc::host {

Eigen::Matrix3d to_eigen(const Mat3& m) {
    Eigen::Matrix3d out;
    for (int r = 0; r < 3; ++r) {
        const Vec3& row = m.row[static_cast<std::size_t>(r)];
        out.row(r) << row.x, row.y, row.z;
    }
    return out;
}

Mat3 to_mat(const Eigen::Matrix3d& m) {
    Mat3 out;
    for (int r = 0; r < 3; ++r) {
        out.row[static_cast<std::size_t>(r)] = {m(r, 0), m(r, 1), m(r, 2)};
    }
    return out;
}

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
    Eigen::Matrix3d m;
    m << 0.0, -v[2], v[1], v[2], 0.0, -v[0], -v[1], v[0], 0.0;
    return m;
}

Eigen::Matrix3d exp_turn(const Eigen::Vector3d& w) {
    const double angle = w.norm();
    const Eigen::Matrix3d k = skew(w);
    if (angle < 1e-7) {
        return Eigen::Matrix3d::Identity() + k + 0.5 * k * k;
    }
    return Eigen::Matrix3d::Identity() + (std::sin(angle) / angle) * k +
           ((1.0 - std::cos(angle)) / (angle * angle)) * k * k;
}

Eigen::Vector3d log_turn(const Eigen::Matrix3d& r) {
    const Eigen::AngleAxisd turn(Eigen::Quaterniond(r).normalized());
    return turn.angle() * turn.axis();
}

Eigen::Vector3d axial(const Eigen::Matrix3d& r) { return {r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1)}; }

Eigen::Matrix3d nearest_turn(const Eigen::Matrix3d& a_bt) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(a_bt, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d sign(1.0, 1.0, 1.0);
    sign[2] = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
    return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

Motion fit_motion(std::span<const PlacePair> pairs) {
    double weight = 0.0;
    Eigen::Vector3d to = Eigen::Vector3d::Zero();
    Eigen::Vector3d from = Eigen::Vector3d::Zero();
    for (const PlacePair& p : pairs) {
        weight += p.weight;
        to += p.weight * p.to;
        from += p.weight * p.from;
    }
    to /= weight;
    from /= weight;
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const PlacePair& p : pairs) {
        sum += p.weight * (p.to - to) * (p.from - from).transpose();
    }
    Motion out;
    out.r = nearest_turn(sum);
    out.t = to - out.r * from;
    return out;
}

double chi_squared_limit(double k, double tail) {
    double low = -10.0;
    double high = 10.0;
    for (int i = 0; i < 60; ++i) {  // the normal quantile
        const double middle = 0.5 * (low + high);
        (0.5 * std::erfc(middle / std::sqrt(2.0)) > tail ? low : high) = middle;
    }
    const double h = 2.0 / (9.0 * k);
    return k * std::pow(std::max(1.0 - h + low * std::sqrt(h), 0.0), 3);
}

}  // namespace sc::host
