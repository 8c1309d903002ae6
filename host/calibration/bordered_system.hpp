// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Dense>

/// Normal equations of a fit with a few unknowns common to all views and V unknowns of each view's own, which are
/// eliminated view by view (Schur complement). All unknowns are small steps about the present state.

namespace sc::host {

template <int V>
class BorderedSystem {
public:
    using ViewMatrix = Eigen::Matrix<double, V, V>;
    using ViewVector = Eigen::Matrix<double, V, 1>;
    using ViewJacobian = Eigen::Matrix<double, 3, V>;
    /// d residual / d common unknown, from column `at` on.
    struct Part {
        Eigen::Index at;
        Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 6> jacobian;
    };

    BorderedSystem(Eigen::Index common, std::size_t views)
        : a_(Eigen::MatrixXd::Zero(common, common)), b_(Eigen::VectorXd::Zero(common)), views_(views) {
        for (View& view : views_) {
            view.c.setZero(V, common);
        }
    }

    /// Measured less predicted, with the weights of its coordinates (1/σ²).
    template <class Parts>
    void add(std::size_t view, const Eigen::Vector3d& residual, const Eigen::Vector3d& weight, const Parts& parts,
             const ViewJacobian& own) {
        View& v = views_[view];
        const Eigen::Matrix<double, V, 3> own_w = own.transpose() * weight.asDiagonal();
        v.d += own_w * own;
        v.g += own_w * residual;
        for (const Part& p : parts) {
            const Eigen::Index np = p.jacobian.cols();
            v.c.middleCols(p.at, np) += own_w * p.jacobian;
            const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::ColMajor, 6, 3> pw =
                p.jacobian.transpose() * weight.asDiagonal();
            b_.segment(p.at, np) += pw * residual;
            for (const Part& q : parts) {
                a_.block(p.at, q.at, np, q.jacobian.cols()) += pw * q.jacobian;
            }
        }
    }
    /// A view's own unknowns are known to be `residual` off, with these weights.
    void add_prior(std::size_t view, const ViewVector& residual, const ViewVector& weight) {
        views_[view].d.diagonal() += weight;
        views_[view].g += weight.cwiseProduct(residual);
    }
    void add_common_prior(Eigen::Index at, double residual, double weight) {
        a_(at, at) += weight;
        b_[at] += weight * residual;
    }

    struct Step {
        Eigen::VectorXd common;
        std::vector<ViewVector> own;
    };
    /// With every diagonal raised by `damping` of itself.
    [[nodiscard]] Step solve(double damping) const {
        Eigen::MatrixXd a = a_;
        a.diagonal() *= 1.0 + damping;
        Eigen::VectorXd b = b_;
        std::vector<ViewMatrix> inverse;
        for (const View& view : views_) {
            ViewMatrix d = view.d;
            d.diagonal() *= 1.0 + damping;
            inverse.push_back(d.inverse());
            const Eigen::MatrixXd k = inverse.back() * view.c;
            a.noalias() -= view.c.transpose() * k;
            b.noalias() -= k.transpose() * view.g;
        }
        Step out;
        const Eigen::VectorXd scale = scale_of(a);
        const Eigen::MatrixXd scaled = scale.asDiagonal() * a * scale.asDiagonal();
        out.common = scale.asDiagonal() * scaled.ldlt().solve(Eigen::VectorXd(scale.asDiagonal() * b));
        for (std::size_t i = 0; i < views_.size(); ++i) {
            out.own.push_back(inverse[i] * (views_[i].g - views_[i].c * out.common));
        }
        return out;
    }

    struct Spread {
        Eigen::MatrixXd common;       ///< covariance of the common unknowns
        std::vector<ViewMatrix> own;  ///< of each view's own
    };
    [[nodiscard]] Spread covariance() const {
        Eigen::MatrixXd a = a_;
        std::vector<ViewMatrix> inverse;
        std::vector<Eigen::MatrixXd> gain;
        for (const View& view : views_) {
            inverse.push_back(view.d.inverse());
            gain.emplace_back(inverse.back() * view.c);
            a.noalias() -= view.c.transpose() * gain.back();
        }
        const Eigen::VectorXd scale = scale_of(a);
        const Eigen::MatrixXd scaled = scale.asDiagonal() * a * scale.asDiagonal();
        Spread out;
        out.common = scale.asDiagonal() * scaled.ldlt().solve(Eigen::MatrixXd::Identity(a.rows(), a.cols())) *
                     scale.asDiagonal();
        for (std::size_t i = 0; i < views_.size(); ++i) {
            out.own.push_back(inverse[i] + ViewMatrix(gain[i] * out.common * gain[i].transpose()));
        }
        return out;
    }

private:
    struct View {
        ViewMatrix d = ViewMatrix::Zero();
        ViewVector g = ViewVector::Zero();
        Eigen::Matrix<double, V, Eigen::Dynamic> c;
    };

    /// Metres and radians stand side by side: each unknown in units of its own.
    static Eigen::VectorXd scale_of(const Eigen::MatrixXd& a) {
        return a.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 1.0; });
    }

    Eigen::MatrixXd a_;
    Eigen::VectorXd b_;
    std::vector<View> views_;
};

/// Levenberg-Marquardt. `system(state)` gives the normal equations, `cost(state)` the weighted sum of squares,
/// `moved(state, step)` the next state. Returns the cost reached.
template <class State, class System, class Cost, class Moved>
double minimise(State& state, const System& system, const Cost& cost, const Moved& moved, int rounds = 30) {
    double damping = 1e-9;
    double now = cost(state);
    for (int round = 0; round < rounds; ++round) {
        const auto equations = system(state);
        bool better = false;
        for (int attempt = 0; attempt < 12 && !better; ++attempt) {
            State next = moved(state, equations.solve(damping));
            const double then = cost(next);
            if (std::isfinite(then) && then <= now) {
                better = true;
                const bool at_rest = now - then <= 1e-9 * (1.0 + now);
                state = std::move(next);
                now = then;
                damping = damping * 0.1 > 1e-12 ? damping * 0.1 : 1e-12;
                if (at_rest) {
                    return now;
                }
            } else {
                damping = damping * 30.0 > 1e-6 ? damping * 30.0 : 1e-6;
            }
        }
        if (!better) {
            return now;
        }
    }
    return now;
}

}  // namespace sc::host
