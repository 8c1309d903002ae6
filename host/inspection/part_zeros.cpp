// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/part_zeros.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "host/inspection/active_set.hpp"

namespace sc::host {

namespace {

constexpr double kMm = 1e3;

/// Of a machined feature, in the blank's frame.
Vec3 machined_place(const BlankModel& model, const BlankFeature& f, const Vec3& zero) {
    return zero + model.zeros[f.zero].axes.transposed() * f.machined;
}

Vec3 place_of(const BlankModel& model, const BlankTolerance::End& end, const std::vector<Vec3>& zeros) {
    const BlankFeature& f = model.features[end.feature];
    return end.machined ? machined_place(model, f, zeros[f.zero]) : f.rough;
}

/// Off its rough counterpart, along the axes of its part zero.
Vec3 offset_of(const BlankModel& model, const BlankFeature& f, const Vec3& zero) {
    return model.zeros[f.zero].axes * (machined_place(model, f, zero) - f.rough);
}

double allowance_of(const BlankModel& model, const BlankFeature& f, const Vec3& zero) {
    const Vec3 d = offset_of(model, f, zero);
    return f.kind == FeatureKind::bore ? f.machined_radius - f.rough_radius - std::hypot(d.x, d.y) : -d.z;
}

/// The unknowns are the places of all zeros in mm, three each; with `margin` the smallest margin is one more, the last.
class Problem {
public:
    explicit Problem(const BlankModel& model) : model_(&model), n_(static_cast<Eigen::Index>(3 * model.zeros.size())) {
        start_ = Eigen::VectorXd::Zero(n_);
        std::vector<double> count(model.zeros.size(), 0.0);
        for (const BlankFeature& f : model.features) {
            const Vec3 best = f.rough - model.zeros[f.zero].axes.transposed() * f.machined;
            for (Eigen::Index axis = 0; axis < 3; ++axis) {
                start_[column(f.zero) + axis] += kMm * best[static_cast<std::size_t>(axis)];
            }
            count[f.zero] += 1.0;
        }
        for (std::size_t i = 0; i < count.size(); ++i) {
            start_.segment<3>(column(i)) /= std::max(count[i], 1.0);
        }
        // Tangents of the cones from all around to begin with: no zero can run away.
        for (std::size_t i = 0; i < model.features.size(); ++i) {
            const BlankFeature& f = model.features[i];
            const int around = f.kind == FeatureKind::bore ? 8 : 1;
            for (int k = 0; k < around; ++k) {
                const double angle = 0.25 * 3.141592653589793 * k;
                add_cut(i, {std::cos(angle), std::sin(angle), 0.0});
            }
        }
    }

    ZeroPlacement solve() {
        ZeroPlacement out;
        const auto [h, g] = tolerances();
        ConvexSolution solution = until_round(h, g, false, start_);
        if (!solution.feasible) {
            return out;
        }
        // Where the tolerances see no difference, the smallest margin decides.
        const Eigen::VectorXd centred = solution.y;
        const Eigen::MatrixXd blind = null_space(h);
        Eigen::VectorXd best = centred;
        if (blind.cols() > 0) {
            blind_ = &blind;
            base_ = centred;
            const Eigen::Index k = blind.cols();
            const Eigen::MatrixXd nothing = Eigen::MatrixXd::Zero(k + 1, k + 1);
            Eigen::VectorXd first = Eigen::VectorXd::Zero(k + 1);
            first[k] = -1.0;
            solution = until_round(nothing, -Eigen::VectorXd::Unit(k + 1, k), true, first);
            if (!solution.feasible) {
                return out;
            }
            out.kkt_residual = kkt_residual(nothing, -Eigen::VectorXd::Unit(k + 1, k), rows(true), solution);
            floor_ = solution.y[k] - 1e-9;
            const Eigen::VectorXd way = blind.transpose() * (centred - start_);
            const ConvexSolution last = until_round(Eigen::MatrixXd::Identity(k, k), way, false, solution.y.head(k));
            best = centred + blind * (last.feasible ? last.y : Eigen::VectorXd(solution.y.head(k)));
        }
        out.feasible = true;
        out.zeros = zeros_of(best);
        out.at = evaluate_zeros(*model_, out.zeros);
        return out;
    }

private:
    struct Cut {
        std::size_t feature = 0;
        Eigen::VectorXd a;  ///< allowance ≤ (for a cone) or = (for a plane) c + a · places
        double c = 0.0;
        bool plane = false;
    };

    static Eigen::Index column(std::size_t zero) { return static_cast<Eigen::Index>(3 * zero); }

    [[nodiscard]] std::vector<Vec3> zeros_of(const Eigen::VectorXd& y) const {
        std::vector<Vec3> out;
        for (std::size_t i = 0; i < model_->zeros.size(); ++i) {
            const Eigen::Index c = column(i);
            out.push_back({y[c] / kMm, y[c + 1] / kMm, y[c + 2] / kMm});
        }
        return out;
    }

    /// `way`: unit, in the zero's x and y; the tangent there.
    void add_cut(std::size_t feature, const Vec3& way) {
        const BlankFeature& f = model_->features[feature];
        const Mat3& axes = model_->zeros[f.zero].axes;
        Cut cut{feature, Eigen::VectorXd::Zero(n_), 0.0, f.kind == FeatureKind::plane};
        const Vec3 direction = cut.plane ? axes.row[2] : way.x * axes.row[0] + way.y * axes.row[1];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            cut.a[column(f.zero) + static_cast<Eigen::Index>(axis)] = -direction[axis];
        }
        cut.c = kMm * (f.machined_radius - f.rough_radius - dot(direction, axes.transposed() * f.machined - f.rough));
        cuts_.push_back(cut);
    }

    /// Tolerances as a quadratic ½ yᵀHy + gᵀy of the places: squares of the distances' relative errors.
    [[nodiscard]] std::pair<Eigen::MatrixXd, Eigen::VectorXd> tolerances() const {
        Eigen::MatrixXd h = Eigen::MatrixXd::Zero(n_, n_);
        Eigen::VectorXd g = Eigen::VectorXd::Zero(n_);
        const std::vector<Vec3> at_zero(model_->zeros.size());
        for (const BlankTolerance& t : model_->tolerances) {
            Eigen::VectorXd a = Eigen::VectorXd::Zero(n_);
            const auto axis = static_cast<Eigen::Index>(t.axis);
            for (const auto& [end, sign] : {std::pair{t.first, 1.0}, std::pair{t.second, -1.0}}) {
                if (end.machined) {
                    a[column(model_->features[end.feature].zero) + axis] += sign;
                }
            }
            const double fixed =
                place_of(*model_, t.first, at_zero)[t.axis] - place_of(*model_, t.second, at_zero)[t.axis];
            const double half = 0.5 * kMm * (t.upper - t.lower);
            const double error = kMm * (fixed - 0.5 * (t.lower + t.upper)) / half;
            a /= half;
            h += 2.0 * a * a.transpose();
            g += 2.0 * error * a;
        }
        return {h, g};
    }

    static Eigen::MatrixXd null_space(const Eigen::MatrixXd& h) {
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(h);
        Eigen::Index count = 0;
        while (count < h.rows() &&
               eigen.eigenvalues()[count] < 1e-9 * std::max(eigen.eigenvalues()[h.rows() - 1], 1e-12)) {
            ++count;
        }
        return eigen.eigenvectors().leftCols(count);
    }

    /// All cuts as rows, in the unknowns of the present stage.
    [[nodiscard]] HalfSpaces rows(bool margin) const {
        const Eigen::Index k = blind_ != nullptr ? blind_->cols() : n_;
        std::vector<std::pair<Eigen::VectorXd, double>> list;
        for (const Cut& cut : cuts_) {
            Eigen::VectorXd a = Eigen::VectorXd::Zero(k + (margin ? 1 : 0));
            a.head(k) = blind_ != nullptr ? Eigen::VectorXd(blind_->transpose() * cut.a) : cut.a;
            const double c = cut.c + (blind_ != nullptr ? cut.a.dot(base_) : 0.0) - kMm * model_->min_allowance;
            if (margin) {
                a[k] = -1.0;
            }
            list.emplace_back(a, (margin ? 0.0 : std::max(floor_, 0.0)) - c);
            if (cut.plane && model_->max_plane_allowance > 0.0) {
                Eigen::VectorXd upper = -a;
                if (margin) {
                    upper[k] = 0.0;
                }
                list.emplace_back(upper, c + kMm * (model_->min_allowance - model_->max_plane_allowance));
            }
        }
        HalfSpaces out;
        out.unknowns = k + (margin ? 1 : 0);
        out.a.resize(static_cast<Eigen::Index>(list.size()), out.unknowns);
        out.b.resize(static_cast<Eigen::Index>(list.size()));
        for (std::size_t i = 0; i < list.size(); ++i) {
            out.a.row(static_cast<Eigen::Index>(i)) = list[i].first.transpose();
            out.b[static_cast<Eigen::Index>(i)] = list[i].second;
        }
        return out;
    }

    /// Solves, adds the tangents of cones that the answer breaks, and again until it breaks none.
    ConvexSolution until_round(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, bool margin,
                               const Eigen::VectorXd& start) {
        ConvexSolution solution;
        solution.y = start;
        for (int round = 0; round < 200; ++round) {
            const Eigen::VectorXd from = solution.y;
            solution = solve_convex(h, g, rows(margin), from);
            if (!solution.feasible) {
                return solution;
            }
            const Eigen::VectorXd places =
                blind_ != nullptr ? Eigen::VectorXd(base_ + *blind_ * solution.y.head(blind_->cols())) : solution.y;
            const double asked = margin ? solution.y[solution.y.size() - 1] : std::max(floor_, 0.0);
            const std::vector<Vec3> zeros = zeros_of(places);
            bool broken = false;
            for (std::size_t i = 0; i < model_->features.size(); ++i) {
                const BlankFeature& f = model_->features[i];
                const double has = kMm * (allowance_of(*model_, f, zeros[f.zero]) - model_->min_allowance);
                if (f.kind == FeatureKind::bore && has < asked - 1e-9) {
                    const Vec3 d = offset_of(*model_, f, zeros[f.zero]);
                    const double length = std::hypot(d.x, d.y);
                    add_cut(i, {d.x / length, d.y / length, 0.0});
                    broken = true;
                }
            }
            if (!broken) {
                break;
            }
        }
        return solution;
    }

    const BlankModel* model_;
    Eigen::Index n_;
    Eigen::VectorXd start_;
    std::vector<Cut> cuts_;
    const Eigen::MatrixXd* blind_ = nullptr;  ///< directions that are left; all of them at first
    Eigen::VectorXd base_;
    double floor_ = 0.0;  ///< mm of margin that is not given up again
};

}  // namespace

ZeroEvaluation evaluate_zeros(const BlankModel& model, const std::vector<Vec3>& zeros) {
    ZeroEvaluation out;
    out.least_radial = out.least_axial = std::numeric_limits<double>::infinity();
    for (const BlankFeature& f : model.features) {
        const double allowance = allowance_of(model, f, zeros[f.zero]);
        out.allowance.push_back(allowance);
        double& least = f.kind == FeatureKind::bore ? out.least_radial : out.least_axial;
        least = std::min(least, allowance);
    }
    out.least_margin = std::min(out.least_radial, out.least_axial) - model.min_allowance;
    for (const BlankTolerance& t : model.tolerances) {
        const double distance = place_of(model, t.first, zeros)[t.axis] - place_of(model, t.second, zeros)[t.axis];
        out.distance.push_back(distance);
        out.tolerance_error += std::abs(distance - 0.5 * (t.lower + t.upper)) / (0.5 * (t.upper - t.lower)) /
                               static_cast<double>(model.tolerances.size());
    }
    return out;
}

ZeroPlacement place_zeros(const BlankModel& model) { return Problem(model).solve(); }

}  // namespace sc::host
