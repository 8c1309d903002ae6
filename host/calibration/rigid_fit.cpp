// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/rigid_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "host/calibration/motion.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr double kFalseAlarm = 1e-4;
constexpr std::size_t kMostTriples = 3000;

struct Match {
    int id = 0;
    Eigen::Vector3d to;
    Eigen::Vector3d from;
    Eigen::Vector3d to_variance;
    Eigen::Vector3d from_variance;
    bool used = true;
};

Eigen::Vector3d variance_of(const SeenMarker& m, double sigma) {
    const Eigen::Vector3d stated = to_eigen(m.sigma);
    return stated.maxCoeff() > 0.0 ? Eigen::Vector3d(stated.cwiseAbs2()) : Eigen::Vector3d::Constant(sigma * sigma);
}

Eigen::Matrix3d covariance_of(const Match& m, const Eigen::Matrix3d& r) {
    Eigen::Matrix3d sum = r * m.from_variance.asDiagonal() * r.transpose();
    sum.diagonal() += m.to_variance;
    return sum;
}

class Fit {
public:
    Fit(const std::filesystem::path& file, std::vector<Match> matches, const RigidOptions& options)
        : file_(file), matches_(std::move(matches)), options_(options) {}

    RigidFit run() {
        refuse_line();
        start();
        refine();
        for (std::size_t dropped = 0; options_.find_wrong; ++dropped) {
            const std::size_t worst = worst_match();
            if (worst == matches_.size()) {
                break;
            }
            if (used() <= 4 || 2 * (dropped + 1) >= matches_.size()) {
                refuse("too many markers do not match",
                       std::to_string(dropped + 1) + " of " + std::to_string(matches_.size()),
                       "check that both files number the same markers, and their units");
            }
            matches_[worst].used = false;
            refine();
        }
        return finish();
    }

private:
    [[noreturn]] void refuse(std::string problem, std::string value, std::string action) const {
        throw InputError({.file = file_.string(),
                          .problem = std::move(problem),
                          .value = std::move(value),
                          .action = std::move(action)});
    }
    [[nodiscard]] std::size_t used() const {
        return static_cast<std::size_t>(std::ranges::count(matches_, true, &Match::used));
    }

    void refuse_line() const {
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();
        for (const Match& m : matches_) {
            mean += m.to / static_cast<double>(matches_.size());
        }
        Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
        for (const Match& m : matches_) {
            spread += (m.to - mean) * (m.to - mean).transpose();
        }
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
        const Eigen::Vector3d size = axes.eigenvalues().cwiseMax(0.0).cwiseSqrt();
        if (size[1] < 0.01 * size[2]) {
            const Eigen::Vector3d u = axes.eigenvectors().col(2);
            refuse("the markers lie on a line: the turn about it is not seen; its direction",
                   fmt::format("({:.2f}, {:.2f}, {:.2f})", u[0], u[1], u[2]), "add markers beside the line");
        }
    }

    /// Sum over all matches of how badly they fit, each counted up to a limit.
    [[nodiscard]] double capped_cost(const Motion& motion) const {
        double sum = 0.0;
        for (const Match& m : matches_) {
            const Eigen::Vector3d variance = m.to_variance + Eigen::Vector3d::Constant(m.from_variance.maxCoeff());
            sum += std::min((m.to - motion * m.from).cwiseAbs2().cwiseQuotient(variance).sum(), 50.0);
        }
        return sum;
    }

    [[nodiscard]] static PlacePair pair_of(const Match& m) {
        return {m.to, m.from, 1.0 / (m.to_variance.sum() + m.from_variance.sum())};
    }

    /// All markers at once; where that does not fit, the best of the fits to three of them.
    void start() {
        std::vector<PlacePair> all;
        for (const Match& m : matches_) {
            all.push_back(pair_of(m));
        }
        motion_ = fit_motion(all);
        if (!options_.find_wrong || capped_cost(motion_) < 10.0 * static_cast<double>(matches_.size()) ||
            matches_.size() < 4) {
            return;
        }
        double least = capped_cost(motion_);
        const std::size_t n = matches_.size();
        const std::size_t triples = n * (n - 1) * (n - 2) / 6;
        const std::size_t stride = std::max<std::size_t>(1, triples / kMostTriples);
        std::size_t count = 0;
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t j = i + 1; j < n; ++j) {
                for (std::size_t k = j + 1; k < n; ++k) {
                    if (count++ % stride != 0) {
                        continue;
                    }
                    const Motion motion = fit_motion(std::array{all[i], all[j], all[k]});
                    const double cost = capped_cost(motion);
                    if (cost < least) {
                        least = cost;
                        motion_ = motion;
                    }
                }
            }
        }
        for (Match& m : matches_) {
            const Eigen::Vector3d variance = m.to_variance + Eigen::Vector3d::Constant(m.from_variance.maxCoeff());
            m.used = (m.to - motion_ * m.from).cwiseAbs2().cwiseQuotient(variance).sum() < 400.0;
        }
        if (used() < 4) {
            refuse("no transform brings more than three markers together", std::to_string(n) + " pairs",
                   "check that both files number the same markers, and their units");
        }
    }

    /// Gauss-Newton about the markers' middle, so that turn and place are nearly independent.
    void refine() {
        middle_.setZero();
        for (const Match& m : matches_) {
            middle_ += m.used ? Eigen::Vector3d(m.from / static_cast<double>(used())) : Eigen::Vector3d::Zero();
        }
        for (int round = 0; round < 20; ++round) {
            information_.setZero();
            Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
            const Eigen::Vector3d centre = motion_ * middle_;
            for (const Match& m : matches_) {
                if (!m.used) {
                    continue;
                }
                const Eigen::Matrix3d weight = covariance_of(m, motion_.r).inverse();
                Eigen::Matrix<double, 3, 6> j;
                j << -skew(motion_ * m.from - centre), Eigen::Matrix3d::Identity();
                information_ += j.transpose() * weight * j;
                right += j.transpose() * weight * (m.to - motion_ * m.from);
            }
            const Eigen::Matrix<double, 6, 1> step = information_.ldlt().solve(right);
            const Eigen::Matrix3d turn = exp_turn(step.head<3>());
            motion_.t = turn * (motion_.t - centre) + centre + step.tail<3>();
            motion_.r = turn * motion_.r;
            if (step.head<3>().norm() < 1e-13 && step.tail<3>().norm() < 1e-13) {
                break;
            }
        }
    }

    /// Residual in units of its own uncertainty, with what the fit took of it given back.
    [[nodiscard]] double surprise_of(const Match& m) const {
        const Eigen::Vector3d residual = m.to - motion_ * m.from;
        Eigen::Matrix3d spread = covariance_of(m, motion_.r);
        Eigen::Matrix<double, 3, 6> j;
        j << -skew(motion_ * m.from - motion_ * middle_), Eigen::Matrix3d::Identity();
        const Eigen::Matrix3d of_fit = j * information_.inverse() * j.transpose();
        const Eigen::Matrix3d floor = 1e-3 * spread;
        spread += (m.used ? -1.0 : 1.0) * of_fit + floor;
        return residual.dot(spread.ldlt().solve(residual));
    }

    [[nodiscard]] std::size_t worst_match() const {
        std::size_t worst = matches_.size();
        double most = chi_squared_limit(3.0, kFalseAlarm / static_cast<double>(matches_.size()));
        if (used() <= 3) {
            return worst;
        }
        for (std::size_t i = 0; i < matches_.size(); ++i) {
            const double s = matches_[i].used ? surprise_of(matches_[i]) : 0.0;
            if (s > most) {
                most = s;
                worst = i;
            }
        }
        return worst;
    }

    RigidFit finish() {
        RigidFit out;
        double squares = 0.0;
        for (const Match& m : matches_) {
            const Eigen::Vector3d residual = m.to - motion_ * m.from;
            out.markers.push_back({m.id, m.used, to_vec(residual), surprise_of(m)});
            if (m.used) {
                squares += residual.squaredNorm();
                out.chi_squared += residual.dot(covariance_of(m, motion_.r).ldlt().solve(residual));
            }
        }
        out.freedom = 3.0 * static_cast<double>(used()) - 6.0;
        out.rms = std::sqrt(squares / (3.0 * static_cast<double>(used())));
        if (out.chi_squared > chi_squared_limit(out.freedom, 1e-3)) {
            out.raised = std::sqrt(out.chi_squared / out.freedom);
        }
        // From (turn, place of the middle) to ξ: t changes by δ_middle − w × middle.
        const Eigen::Matrix<double, 6, 6> spread = out.raised * out.raised * information_.inverse();
        refuse_blind(spread);
        Eigen::Matrix<double, 6, 6> to_xi = Eigen::Matrix<double, 6, 6>::Identity();
        to_xi.bottomLeftCorner<3, 3>() = skew(motion_ * middle_);
        Eigen::Matrix<double, 6, 6> xi = to_xi * spread * to_xi.transpose();
        xi = (0.5 * (xi + xi.transpose())).eval();
        for (int r = 0; r < 6; ++r) {
            for (int c = 0; c < 6; ++c) {
                out.covariance.at[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] = xi(r, c);
            }
        }
        out.rotation = to_mat(motion_.r);
        out.translation = to_vec(motion_.t);
        return out;
    }

    void refuse_blind(const Eigen::Matrix<double, 6, 6>& spread) const {
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> turn(Eigen::Matrix3d(spread.topLeftCorner<3, 3>()));
        const double sigma = std::sqrt(turn.eigenvalues()[2]);
        if (!(sigma <= options_.most_turn)) {
            const Eigen::Vector3d u = turn.eigenvectors().col(2);
            refuse(fmt::format("the markers do not show the turn about a direction (1 sigma: {:.3g} deg)",
                               sigma * 180.0 / std::numbers::pi),
                   fmt::format("({:.2f}, {:.2f}, {:.2f})", u[0], u[1], u[2]), "spread the markers further across it");
        }
        const double place =
            std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(Eigen::Matrix3d(spread.bottomRightCorner<3, 3>()))
                          .eigenvalues()[2]);
        if (!(place <= options_.most_place)) {
            refuse("the markers are too uncertain for a transform; 1 sigma in mm", fmt::format("{:.3g}", place * 1e3),
                   "measure more markers, or each more often");
        }
    }

    std::filesystem::path file_;
    std::vector<Match> matches_;
    RigidOptions options_;
    Motion motion_;
    Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
    Eigen::Matrix<double, 6, 6> information_ = Eigen::Matrix<double, 6, 6>::Zero();
};

}  // namespace

RigidFit fit_rigid(const std::filesystem::path& file, const std::vector<SeenMarker>& to,
                   const std::vector<SeenMarker>& from, const RigidOptions& options) {
    std::vector<Match> matches;
    for (const SeenMarker& a : to) {
        const auto b = std::ranges::find(from, a.id, &SeenMarker::id);
        if (b != from.end()) {
            matches.push_back({a.id, to_eigen(a.place), to_eigen(b->place), variance_of(a, options.sigma),
                               variance_of(*b, options.sigma), true});
        }
    }
    if (matches.size() < 3) {
        throw InputError({.file = file.string(),
                          .problem = "has fewer than three markers in common with the other file",
                          .value = std::to_string(matches.size()),
                          .action = "measure three or more, not on a line, in both frames"});
    }
    return Fit(file, std::move(matches), options).run();
}

}  // namespace sc::host
