// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

/// Small convex problems with many rows, for the sources of this folder only (it pulls in Eigen).

namespace sc::host {

/// Rows a·y ≥ b of a problem in few unknowns; one row each. Of `a` only the first `unknowns` columns count.
struct HalfSpaces {
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> a;
    Eigen::VectorXd b;
    Eigen::Index unknowns = 0;
    [[nodiscard]] Eigen::Index size() const noexcept { return b.size(); }
    [[nodiscard]] auto row(Eigen::Index i) const { return a.row(i).head(unknowns); }
    [[nodiscard]] auto all() const { return a.leftCols(unknowns); }
};

struct ConvexSolution {
    bool feasible = false;
    Eigen::VectorXd y;
    std::vector<std::uint32_t> active;  ///< rows that hold with equality and push
    std::vector<double> multiplier;     ///< of them, > 0
};

/// Minimises ½ yᵀHy + gᵀy over rows, H positive semidefinite and the minimum bounded: Goldfarb and Idnani's dual method
/// (1983), made strictly convex by a term about the last answer that is repeated until it no longer moves
/// (Rockafellar's proximal point, finite for linear programs). `start` is where that term begins. Rows are looked at
/// all together, but only a few hundred at a time enter the method. Works best with unknowns and rows of size 1.
[[nodiscard]] ConvexSolution solve_convex(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const HalfSpaces& rows,
                                          const Eigen::VectorXd& start);

/// The largest of: |Hy + g − Σ u a| per unknown, how far a row is broken, u·(a·y − b) over all active rows, −u.
[[nodiscard]] double kkt_residual(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const HalfSpaces& rows,
                                  const ConvexSolution& solution);

}  // namespace sc::host
