// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/hand_eye_suggest.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include <Eigen/Dense>

#include "host/calibration/motion.hpp"
#include "host/formats/error.hpp"

namespace sc::host {

namespace {

constexpr double kArm = 0.25;

struct Marker {
    Eigen::Vector3d place;  ///< in b
    Eigen::Vector3d sigma;  ///< in c
};

class Information {
public:
    Information(const std::vector<HandEyeView>& views, const Rigid<frame::F, frame::C>& f_from_c,
                const HandEyeNoise& noise)
        : x_{to_eigen(f_from_c.rotation), to_eigen(f_from_c.translation)}, noise_(noise) {
        std::map<int, std::pair<Marker, double>> sums;
        for (const HandEyeView& view : views) {
            const Motion flange = flange_of(view);
            for (const SeenMarker& seen : view.markers) {
                auto& [marker, count] =
                    sums.try_emplace(seen.id, Marker{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}, 0.0)
                        .first->second;
                marker.place += flange * (x_ * to_eigen(seen.place));
                marker.sigma = to_eigen(seen.sigma).maxCoeff() > 0.0 ? to_eigen(seen.sigma)
                                                                     : Eigen::Vector3d::Constant(noise.marker);
                count += 1.0;
            }
        }
        for (auto& [id, sum] : sums) {
            ids_[id] = markers_.size();
            markers_.push_back({sum.first.place / sum.second, sum.first.sigma});
        }
        if (markers_.size() < 3) {
            throw InputError({.problem = "fewer than three markers were seen",
                              .value = std::to_string(markers_.size()),
                              .action = "give views of the whole target"});
        }
        total_ = Eigen::MatrixXd::Zero(size(), size());
        for (const HandEyeView& view : views) {
            std::vector<std::size_t> seen;
            for (const SeenMarker& marker : view.markers) {
                seen.push_back(ids_.at(marker.id));
            }
            total_ += of(flange_of(view), seen);
        }
    }

    [[nodiscard]] static Motion flange_of(const HandEyeView& view) {
        return {to_eigen(view.b_from_f.rotation), to_eigen(view.b_from_f.translation)};
    }
    [[nodiscard]] Eigen::Index size() const { return 6 + 3 * static_cast<Eigen::Index>(markers_.size()); }
    [[nodiscard]] std::vector<std::size_t> all() const {
        std::vector<std::size_t> out(markers_.size());
        for (std::size_t i = 0; i < out.size(); ++i) {
            out[i] = i;
        }
        return out;
    }
    [[nodiscard]] Eigen::Vector3d middle() const {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (const Marker& marker : markers_) {
            sum += marker.place;
        }
        return sum / static_cast<double>(markers_.size());
    }

    /// Of one view of these markers.
    [[nodiscard]] Eigen::MatrixXd of(const Motion& flange, const std::vector<std::size_t>& seen) const {
        const auto rows = 3 * static_cast<Eigen::Index>(seen.size());
        Eigen::MatrixXd j = Eigen::MatrixXd::Zero(rows, size());
        Eigen::MatrixXd k(rows, 6);
        Eigen::VectorXd w(rows);
        for (std::size_t i = 0; i < seen.size(); ++i) {
            const auto at = 3 * static_cast<Eigen::Index>(i);
            const Marker& marker = markers_[seen[i]];
            const Eigen::Vector3d in_f = flange.inverse() * marker.place;
            // c = Xᵀ (f − t): X moved by ξ in f, the flange by η in b.
            j.block<3, 3>(at, 0) = x_.r.transpose() * skew(in_f);
            j.block<3, 3>(at, 3) = -x_.r.transpose();
            const Eigen::Matrix3d to_c = x_.r.transpose() * flange.r.transpose();
            j.block<3, 3>(at, 6 + 3 * static_cast<Eigen::Index>(seen[i])) = to_c;
            k.block<3, 3>(at, 0) = to_c * skew(marker.place - flange.t);
            k.block<3, 3>(at, 3) = -to_c;
            w.segment<3>(at) = marker.sigma.cwiseAbs2().cwiseInverse();
        }
        const Eigen::MatrixXd wk = w.asDiagonal() * k;
        Eigen::Matrix<double, 6, 6> own = k.transpose() * wk;
        own.diagonal().head<3>().array() += 1.0 / (noise_.robot_turn * noise_.robot_turn);
        own.diagonal().tail<3>().array() += 1.0 / (noise_.robot_place * noise_.robot_place);
        const Eigen::MatrixXd mixed = wk.transpose() * j;
        return j.transpose() * w.asDiagonal() * j - mixed.transpose() * own.ldlt().solve(mixed);
    }

    /// Of X, with `information` over (X, markers).
    [[nodiscard]] Eigen::Matrix<double, 6, 6> covariance(const Eigen::MatrixXd& information) const {
        const Eigen::Index rest = size() - 6;
        const Eigen::MatrixXd a = information.bottomRightCorner(rest, rest);
        const Eigen::MatrixXd b = information.topRightCorner(6, rest);
        const Eigen::Matrix<double, 6, 6> schur = information.topLeftCorner<6, 6>() - b * a.ldlt().solve(b.transpose());
        const Eigen::Matrix<double, 6, 1> scale = schur.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
        const Eigen::Matrix<double, 6, 6> scaled = scale.asDiagonal() * schur * scale.asDiagonal();
        return scale.asDiagonal() * scaled.ldlt().solve(Eigen::Matrix<double, 6, 6>::Identity()) * scale.asDiagonal();
    }
    /// About the sensor's own place: turned about f's zero, place and turn would hang together.
    [[nodiscard]] Eigen::Matrix<double, 6, 6> about_sensor(const Eigen::Matrix<double, 6, 6>& covariance) const {
        Eigen::Matrix<double, 6, 6> move = Eigen::Matrix<double, 6, 6>::Identity();
        move.bottomLeftCorner<3, 3>() = -skew(x_.t);
        return move * covariance * move.transpose();
    }

    [[nodiscard]] const Eigen::MatrixXd& total() const { return total_; }
    [[nodiscard]] const Motion& x() const { return x_; }

private:
    Motion x_;
    HandEyeNoise noise_;
    std::vector<Marker> markers_;
    std::map<int, std::size_t> ids_;
    Eigen::MatrixXd total_;
};

struct Score {
    double turn = 0.0;
    double place = 0.0;
    double criterion = 0.0;
};

double largest_root(const Eigen::MatrixXd& m) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(m, Eigen::EigenvaluesOnly);
    return std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}

Score score_of(const Information& all, const Eigen::MatrixXd& information, SuggestCriterion criterion) {
    const Eigen::Matrix<double, 6, 6> covariance = all.about_sensor(all.covariance(information));
    Score out{.turn = largest_root(covariance.topLeftCorner<3, 3>()),
              .place = largest_root(covariance.bottomRightCorner<3, 3>())};
    Eigen::Matrix<double, 6, 6> scaled = covariance;
    scaled.topRows<3>() *= kArm;
    scaled.leftCols<3>() *= kArm;
    out.criterion = criterion == SuggestCriterion::worst ? largest_root(scaled)
                                                         : std::pow(std::max(0.0, scaled.determinant()), 1.0 / 12.0);
    return out;
}

std::vector<Motion> candidates_of(const std::vector<HandEyeView>& views, const Information& all,
                                  const SuggestOptions& options) {
    std::mt19937_64 random(options.seed);
    std::uniform_real_distribution<double> even(-1.0, 1.0);
    Eigen::Vector3d least = Eigen::Vector3d::Constant(1e9);
    Eigen::Vector3d most = -least;
    for (const HandEyeView& view : views) {
        const Eigen::Vector3d at = Information::flange_of(view).t;
        least = least.cwiseMin(at);
        most = most.cwiseMax(at);
    }
    least.array() -= options.reach;
    most.array() += options.reach;
    const Eigen::Vector3d middle = all.middle();
    std::vector<Motion> out;
    for (int tries = 0; tries < 50 * options.candidates && static_cast<int>(out.size()) < options.candidates; ++tries) {
        const HandEyeView& from = views[random() % views.size()];
        const Motion flange = Information::flange_of(from);
        Eigen::Vector3d turn(even(random), even(random), even(random));
        turn *= options.turn;
        if (turn.norm() > options.turn) {
            continue;
        }
        const Eigen::Matrix3d r = exp_turn(turn);
        const Motion candidate{r * flange.r, middle + r * (flange.t - middle)};
        if ((candidate.t.array() >= least.array()).all() && (candidate.t.array() <= most.array()).all()) {
            out.push_back(candidate);
        }
    }
    return out;
}

}  // namespace

Covariance<6> expected_covariance(const std::vector<HandEyeView>& views, const Rigid<frame::F, frame::C>& f_from_c,
                                  const HandEyeNoise& noise) {
    const Information all(views, f_from_c, noise);
    const auto covariance = all.covariance(all.total());
    Covariance<6> out;
    for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t j = 0; j < 6; ++j) {
            out.at[i][j] = covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        }
    }
    return out;
}

Suggestion suggest_poses(const std::vector<HandEyeView>& views, const Rigid<frame::F, frame::C>& f_from_c,
                         const SuggestOptions& options) {
    const Information all(views, f_from_c, options.noise);
    std::vector<Motion> poses = candidates_of(views, all, options);
    if (poses.empty()) {
        throw InputError({.problem = "no pose within the reach of the given ones",
                          .action = "allow more with --suggest-reach-mm or --suggest-turn-deg"});
    }
    std::vector<Eigen::MatrixXd> information;
    for (const Motion& pose : poses) {
        information.push_back(all.of(pose, all.all()));
    }
    Eigen::MatrixXd total = all.total();
    const Score now = score_of(all, total, options.criterion);
    Suggestion out;
    out.turn_sigma = now.turn;
    out.place_sigma = now.place;
    out.criterion = now.criterion;
    for (int n = 0; n < options.count && !poses.empty(); ++n) {
        std::vector<Score> scores;
        for (const Eigen::MatrixXd& one : information) {
            scores.push_back(score_of(all, total + one, options.criterion));
        }
        if (n == 0) {
            std::vector<double> each;
            for (const Score& score : scores) {
                each.push_back(score.criterion);
            }
            std::ranges::nth_element(each, each.begin() + static_cast<std::ptrdiff_t>(each.size() / 2));
            out.random_criterion = each[each.size() / 2];
        }
        const auto best = std::ranges::min_element(scores, {}, &Score::criterion) - scores.begin();
        const auto at = static_cast<std::size_t>(best);
        out.poses.push_back({.b_from_f = {to_mat(poses[at].r), to_vec(poses[at].t)},
                             .turn_sigma = scores[at].turn,
                             .place_sigma = scores[at].place,
                             .criterion = scores[at].criterion});
        total += information[at];
        poses.erase(poses.begin() + best);
        information.erase(information.begin() + best);
    }
    return out;
}

}  // namespace sc::host
