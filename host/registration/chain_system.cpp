// SPDX-License-Identifier: Apache-2.0
#include "host/registration/chain_system.hpp"

#include <algorithm>
#include <cmath>

namespace sc::host {
namespace {

/// Metres and radians stand side by side: each unknown in units of its own.
Eigen::VectorXd scale_of(const Eigen::MatrixXd& a) {
    return a.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 1.0; });
}

}  // namespace

ChainSystem::ChainSystem(Eigen::Index common, std::size_t markers)
    : a_(Eigen::MatrixXd::Zero(common, common)), b_(Eigen::VectorXd::Zero(common)), markers_(markers) {
    for (Marker& m : markers_) {
        m.coupling.resize(3, 0);
    }
}

/// Of `count` common unknowns from `at` on, the first column of the marker's coupling; they are added if new.
Eigen::Index ChainSystem::column_of(Marker& marker, Eigen::Index at, Eigen::Index count) {
    const auto found = std::ranges::find(marker.at, at);
    if (found != marker.at.end()) {
        return found - marker.at.begin();
    }
    const Eigen::Index first = marker.coupling.cols();
    marker.coupling.conservativeResize(Eigen::NoChange, first + count);
    marker.coupling.rightCols(count).setZero();
    for (Eigen::Index i = 0; i < count; ++i) {
        marker.at.push_back(at + i);
    }
    return first;
}

void ChainSystem::add(std::size_t marker, const Eigen::Vector3d& residual, const Eigen::Vector3d& weight,
                      std::span<const Part> parts, const Eigen::Matrix3d& own) {
    Marker& m = markers_[marker];
    const Eigen::Matrix3d own_w = own.transpose() * weight.asDiagonal();
    m.d.noalias() += own_w * own;
    m.g.noalias() += own_w * residual;
    for (const Part& p : parts) {
        const Eigen::Index np = p.jacobian.cols();
        const Eigen::Index column = column_of(m, p.at, np);
        m.coupling.middleCols(column, np) += own_w * p.jacobian;
        const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::ColMajor, 6, 3> pw =
            p.jacobian.transpose() * weight.asDiagonal();
        b_.segment(p.at, np) += pw * residual;
        for (const Part& q : parts) {
            a_.block(p.at, q.at, np, q.jacobian.cols()) += pw * q.jacobian;
        }
    }
}

void ChainSystem::add_pose(const Eigen::Matrix<double, 6, 1>& residual, const Eigen::Matrix<double, 6, 1>& weight,
                           std::span<const PriorPart> parts) {
    for (const PriorPart& p : parts) {
        const PriorJacobian pw = p.jacobian.transpose() * weight.asDiagonal();
        b_.segment<6>(p.at) += pw * residual;
        for (const PriorPart& q : parts) {
            a_.block<6, 6>(p.at, q.at) += pw * q.jacobian;
        }
    }
}

void ChainSystem::know(Eigen::Index at, double residual, double weight) {
    a_(at, at) += weight;
    b_[at] += weight * residual;
}

void ChainSystem::know_marker(std::size_t marker, const Eigen::Vector3d& residual, double weight) {
    markers_[marker].d.diagonal().array() += weight;
    markers_[marker].g += weight * residual;
}

std::vector<ChainSystem::Spread::Gain> ChainSystem::eliminate(Eigen::MatrixXd& a, Eigen::VectorXd& b,
                                                              double damping) const {
    std::vector<Spread::Gain> gains;
    gains.reserve(markers_.size());
    Eigen::MatrixXd less;
    for (const Marker& m : markers_) {
        Eigen::Matrix3d d = m.d;
        d.diagonal() *= 1.0 + damping;
        Spread::Gain gain{.inverse = d.inverse(), .at = m.at, .times = {}};
        gain.times = gain.inverse * m.coupling;
        less.noalias() = m.coupling.transpose() * gain.times;
        const Eigen::VectorXd of_b = gain.times.transpose() * m.g;
        for (std::size_t c = 0; c < m.at.size(); ++c) {
            const auto column = static_cast<Eigen::Index>(c);
            b[m.at[c]] -= of_b[column];
            for (std::size_t r = 0; r < m.at.size(); ++r) {
                a(m.at[r], m.at[c]) -= less(static_cast<Eigen::Index>(r), column);
            }
        }
        gains.push_back(std::move(gain));
    }
    return gains;
}

ChainSystem::Step ChainSystem::solve(double damping) const {
    Eigen::MatrixXd a = a_;
    a.diagonal() *= 1.0 + damping;
    Eigen::VectorXd b = b_;
    const std::vector<Spread::Gain> gains = eliminate(a, b, damping);
    const Eigen::VectorXd scale = scale_of(a);
    const Eigen::MatrixXd scaled = scale.asDiagonal() * a * scale.asDiagonal();
    Step out;
    out.common = scale.asDiagonal() * scaled.ldlt().solve(Eigen::VectorXd(scale.asDiagonal() * b));
    for (std::size_t i = 0; i < markers_.size(); ++i) {
        Eigen::Vector3d step = gains[i].inverse * markers_[i].g;
        for (std::size_t c = 0; c < gains[i].at.size(); ++c) {
            step -= gains[i].times.col(static_cast<Eigen::Index>(c)) * out.common[gains[i].at[c]];
        }
        out.markers.push_back(step);
    }
    return out;
}

ChainSystem::Spread ChainSystem::covariance() const {
    Eigen::MatrixXd a = a_;
    Eigen::VectorXd b = b_;
    Spread out;
    out.gain_ = eliminate(a, b, 0.0);
    const Eigen::VectorXd scale = scale_of(a);
    const Eigen::MatrixXd scaled = scale.asDiagonal() * a * scale.asDiagonal();
    out.common_ =
        scale.asDiagonal() * scaled.ldlt().solve(Eigen::MatrixXd::Identity(a.rows(), a.cols())) * scale.asDiagonal();
    return out;
}

Eigen::Matrix3d ChainSystem::Spread::marker(std::size_t m) const { return of(m, {}, Eigen::Matrix3d::Identity()); }

Eigen::Matrix3d ChainSystem::Spread::of(std::size_t m, std::span<const Part> parts, const Eigen::Matrix3d& own) const {
    // A marker moves with the common unknowns by −gain, and by a part of its own besides.
    const Gain& gain = gain_[m];
    std::vector<Eigen::Index> at;
    Eigen::Matrix<double, 3, Eigen::Dynamic> j = -own * gain.times;
    at = gain.at;
    for (const Part& p : parts) {
        for (Eigen::Index i = 0; i < p.jacobian.cols(); ++i) {
            const auto found = std::ranges::find(at, p.at + i);
            if (found != at.end()) {
                j.col(found - at.begin()) += p.jacobian.col(i);
            } else {
                at.push_back(p.at + i);
                j.conservativeResize(Eigen::NoChange, j.cols() + 1);
                j.rightCols<1>() = p.jacobian.col(i);
            }
        }
    }
    const Eigen::MatrixXd common = common_(at, at);
    return j * common * j.transpose() + own * gain.inverse * own.transpose();
}

}  // namespace sc::host
