// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Dense>

/// Normal equations of a joint bundle: many markers of three unknowns each, which are eliminated one by one (Schur
/// complement), and some hundred common unknowns (poses, axis, angles), of which a marker touches only those of the
/// views that saw it. All unknowns are small steps about the present state. For chain_fit.cpp.

namespace sc::host {

class ChainSystem {
public:
    using Jacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 6>;
    using PriorJacobian = Eigen::Matrix<double, 6, 6>;
    /// d residual / d common unknowns from column `at` on.
    struct Part {
        Eigen::Index at = 0;
        Jacobian jacobian;
    };
    struct PriorPart {
        Eigen::Index at = 0;
        PriorJacobian jacobian;
    };

    ChainSystem(Eigen::Index common, std::size_t markers);

    /// A sight: measured less predicted, with the weights of its coordinates (1/σ²).
    void add(std::size_t marker, const Eigen::Vector3d& residual, const Eigen::Vector3d& weight,
             std::span<const Part> parts, const Eigen::Matrix3d& own);
    /// A reading of a pose, which touches common unknowns alone.
    void add_pose(const Eigen::Matrix<double, 6, 1>& residual, const Eigen::Matrix<double, 6, 1>& weight,
                  std::span<const PriorPart> parts);
    void know(Eigen::Index at, double residual, double weight);
    void know_marker(std::size_t marker, const Eigen::Vector3d& residual, double weight);

    struct Step {
        Eigen::VectorXd common;
        std::vector<Eigen::Vector3d> markers;
    };
    /// With every diagonal raised by `damping` of itself.
    [[nodiscard]] Step solve(double damping) const;

    /// The inverse of the whole, in parts.
    class Spread {
    public:
        [[nodiscard]] const Eigen::MatrixXd& common() const { return common_; }
        [[nodiscard]] Eigen::Matrix3d marker(std::size_t m) const;
        /// Covariance of `parts`·common + `own`·marker.
        [[nodiscard]] Eigen::Matrix3d of(std::size_t m, std::span<const Part> parts, const Eigen::Matrix3d& own) const;

    private:
        friend class ChainSystem;
        struct Gain {
            Eigen::Matrix3d inverse;  ///< of the marker's own block
            std::vector<Eigen::Index> at;
            Eigen::Matrix<double, 3, Eigen::Dynamic> times;  ///< inverse · coupling
        };
        Eigen::MatrixXd common_;
        std::vector<Gain> gain_;
    };
    [[nodiscard]] Spread covariance() const;

private:
    struct Marker {
        Eigen::Matrix3d d = Eigen::Matrix3d::Zero();
        Eigen::Vector3d g = Eigen::Vector3d::Zero();
        std::vector<Eigen::Index> at;                       ///< common unknowns that it touches
        Eigen::Matrix<double, 3, Eigen::Dynamic> coupling;  ///< a column each
    };
    [[nodiscard]] static Eigen::Index column_of(Marker& marker, Eigen::Index at, Eigen::Index count);
    [[nodiscard]] std::vector<Spread::Gain> eliminate(Eigen::MatrixXd& a, Eigen::VectorXd& b, double damping) const;

    Eigen::MatrixXd a_;
    Eigen::VectorXd b_;
    std::vector<Marker> markers_;
};

}  // namespace sc::host
