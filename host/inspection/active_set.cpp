// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/active_set.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include <Eigen/Dense>

namespace sc::host {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kBroken = 1e-12;  ///< a row counts as kept when it is broken by less

/// Strictly convex: minimises ½ yᵀHy + gᵀy over the listed rows.
class DualMethod {
public:
    DualMethod(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const HalfSpaces& rows,
               const std::vector<std::uint32_t>& listed)
        : factor_(h), rows_(&rows), listed_(&listed) {
        y_ = factor_.solve(-g);
    }

    bool run() {
        for (std::size_t steps = 0; steps < 50 * (listed_->size() + 10); ++steps) {
            const auto broken = most_broken();
            if (!broken) {
                return true;
            }
            if (!enter(*broken)) {
                return false;
            }
        }
        return false;
    }
    [[nodiscard]] ConvexSolution solution() const {
        ConvexSolution out;
        out.feasible = true;
        out.y = y_;
        for (std::size_t i = 0; i < active_.size(); ++i) {
            if (u_[i] > 0.0) {
                out.active.push_back(active_[i]);
                out.multiplier.push_back(u_[i]);
            }
        }
        return out;
    }

private:
    [[nodiscard]] double slack(std::uint32_t row) const { return rows_->row(row).dot(y_) - rows_->b[row]; }

    [[nodiscard]] std::optional<std::uint32_t> most_broken() const {
        double least = -kBroken;
        std::optional<std::uint32_t> out;
        for (const std::uint32_t row : *listed_) {
            if (const double s = slack(row); s < least && std::ranges::find(active_, row) == active_.end()) {
                least = s;
                out = row;
            }
        }
        return out;
    }

    bool enter(std::uint32_t row) {
        const Eigen::VectorXd normal = rows_->row(row).transpose();
        double u = 0.0;
        while (true) {
            const auto q = static_cast<Eigen::Index>(active_.size());
            const Eigen::VectorXd hn = factor_.solve(normal);
            Eigen::VectorXd r(q);
            Eigen::VectorXd z = hn;
            if (q > 0) {
                Eigen::MatrixXd n(normal.size(), q);
                for (Eigen::Index i = 0; i < q; ++i) {
                    n.col(i) = rows_->row(active_[static_cast<std::size_t>(i)]).transpose();
                }
                const Eigen::MatrixXd hi = factor_.solve(n);
                r = (n.transpose() * hi).ldlt().solve(hi.transpose() * normal);
                z = hn - hi * r;
            }
            double t1 = kInfinity;
            Eigen::Index leaves = -1;
            for (Eigen::Index i = 0; i < q; ++i) {
                const double ratio = u_[static_cast<std::size_t>(i)] / r[i];
                if (r[i] > 1e-13 && ratio < t1) {
                    t1 = ratio;
                    leaves = i;
                }
            }
            const double along = z.dot(normal);
            // A row that the active ones nearly span gives no direction: only multipliers move.
            const double t2 = along > 1e-11 * hn.dot(normal) ? -slack(row) / along : kInfinity;
            const double t = std::min(t1, t2);
            if (t == kInfinity) {
                return false;
            }
            for (Eigen::Index i = 0; i < q; ++i) {
                u_[static_cast<std::size_t>(i)] -= t * r[i];
            }
            u += t;
            if (t2 < kInfinity) {
                y_ += t * z;
            }
            if (t2 <= t1) {
                active_.push_back(row);
                u_.push_back(u);
                return true;
            }
            active_.erase(active_.begin() + leaves);
            u_.erase(u_.begin() + leaves);
        }
    }

    Eigen::LDLT<Eigen::MatrixXd> factor_;
    const HalfSpaces* rows_;
    const std::vector<std::uint32_t>* listed_;
    Eigen::VectorXd y_;
    std::vector<std::uint32_t> active_;
    std::vector<double> u_;
};

/// The worst rows at `y` join the list; false if none is broken.
bool list_broken(const HalfSpaces& rows, const Eigen::VectorXd& y, std::size_t most, std::vector<bool>& listed,
                 std::vector<std::uint32_t>& list) {
    const Eigen::VectorXd slack = rows.all() * y - rows.b;
    std::vector<std::uint32_t> broken;
    for (Eigen::Index i = 0; i < slack.size(); ++i) {
        if (slack[i] < -kBroken && !listed[static_cast<std::size_t>(i)]) {
            broken.push_back(static_cast<std::uint32_t>(i));
        }
    }
    const auto worse = [&slack](std::uint32_t a, std::uint32_t b) { return slack[a] < slack[b]; };
    if (broken.size() > most) {
        std::nth_element(broken.begin(), broken.begin() + static_cast<std::ptrdiff_t>(most), broken.end(), worse);
        broken.resize(most);
    }
    for (const std::uint32_t i : broken) {
        listed[i] = true;
        list.push_back(i);
    }
    return !broken.empty();
}

}  // namespace

ConvexSolution solve_convex(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const HalfSpaces& rows,
                            const Eigen::VectorXd& start) {
    // Some rows from everywhere, then those that are broken.
    std::vector<bool> listed(static_cast<std::size_t>(rows.size()), false);
    std::vector<std::uint32_t> list;
    const auto stride = std::max<std::size_t>(1, listed.size() / 200);
    for (std::size_t i = 0; i < listed.size(); i += stride) {
        listed[i] = true;
        list.push_back(static_cast<std::uint32_t>(i));
    }
    // Strong enough for the factors' digits, weak enough that a few repeats do.
    const double pull = h.trace() > 0.0 ? std::max(1e-4 * h.trace() / static_cast<double>(h.rows()), 1e-9) : 1e-3;
    const Eigen::MatrixXd pulled = h + pull * Eigen::MatrixXd::Identity(h.rows(), h.cols());
    ConvexSolution solution;
    solution.y = start;
    list_broken(rows, start, 200, listed, list);
    Eigen::VectorXd looked;  // where all rows were last found to hold
    for (int round = 0; round < 400; ++round) {
        const Eigen::VectorXd before = solution.y;
        while (true) {
            DualMethod method(pulled, g - pull * before, rows, list);
            if (!method.run()) {
                return {};
            }
            solution = method.solution();
            const bool moved = looked.size() == 0 || (solution.y - looked).lpNorm<Eigen::Infinity>() > 1e-13;
            if (!moved || !list_broken(rows, solution.y, 50, listed, list)) {
                looked = solution.y;
                break;
            }
        }
        if ((solution.y - before).lpNorm<Eigen::Infinity>() < 1e-12) {
            break;
        }
    }
    return solution;
}

double kkt_residual(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const HalfSpaces& rows,
                    const ConvexSolution& solution) {
    Eigen::VectorXd gradient = h * solution.y + g;
    double worst = 0.0;
    for (std::size_t i = 0; i < solution.active.size(); ++i) {
        const std::uint32_t row = solution.active[i];
        const double u = solution.multiplier[i];
        gradient -= u * rows.row(row).transpose();
        worst = std::max({worst, -u, std::abs(u * (rows.row(row).dot(solution.y) - rows.b[row]))});
    }
    if (rows.size() > 0) {
        worst = std::max(worst, -(rows.all() * solution.y - rows.b).minCoeff());
    }
    return std::max(worst, gradient.lpNorm<Eigen::Infinity>());
}

}  // namespace sc::host
