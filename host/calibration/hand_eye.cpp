// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/hand_eye.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "host/calibration/hand_eye_setup.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::size_t kLeastViews = 3;
constexpr double kFalseAlarm = 1e-4;         ///< of a whole set
constexpr double kFewTurns = 3.0 * kDegree;  ///< axial vector, rms, that counts as turning
constexpr double kMedian6 = 5.348;           ///< of chi-squared with 6 degrees of freedom

class HandEye {
public:
    HandEye(const std::filesystem::path& file, std::vector<HandEyeView> views, const HandEyeOptions& options)
        : file_(file), options_(options), noise_(options.noise) {
        HandEyeSetup setup = set_up_hand_eye(file, std::move(views), options);
        views_ = std::move(setup.views);
        entries_ = std::move(setup.entries);
        start_ = setup.start;
        result_ = std::move(setup.found);
        poses_given_ = setup.poses_given;
    }

    HandEyeResult run() {
        fit_all();
        return finish();
    }

private:
    [[noreturn]] void refuse(std::string problem, std::string value, std::string action) const {
        throw InputError({.file = file_.string(),
                          .problem = std::move(problem),
                          .value = std::move(value),
                          .action = std::move(action)});
    }

    void build() {
        problem_ = {};
        problem_.turn_sigma = noise_.robot_turn * result_.robot_ratio;
        problem_.place_sigma = noise_.robot_place * result_.robot_ratio;
        in_problem_.clear();
        ids_.clear();
        std::map<int, int> index;
        for (std::size_t i = 0; i < entries_.size(); ++i) {
            const HandEyeEntry& entry = entries_[i];
            if (!entry.used) {
                continue;
            }
            const auto view = static_cast<int>(problem_.read.size());
            problem_.read.push_back(result_.robot_inverted ? entry.f.inverse() : entry.f);
            in_problem_.push_back(i);
            for (const SeenMarker& m : entry.view->markers) {
                const auto [at, added] = index.try_emplace(m.id, static_cast<int>(index.size()));
                if (added) {
                    ids_.push_back(m.id);
                }
                Eigen::Vector3d sigma = to_eigen(m.sigma);
                if (sigma.maxCoeff() <= 0.0) {
                    sigma.setConstant(noise_.marker);
                }
                problem_.sights.push_back(
                    {view, at->second, to_eigen(m.place), (sigma * result_.marker_ratio).cwiseAbs2().cwiseInverse()});
            }
        }
        problem_.markers = static_cast<int>(ids_.size());
    }

    void fit() {
        build();
        fit_ = fit_hand_eye(problem_, start_state(problem_, fitted_ ? fit_.state.x : start_.x));
        fitted_ = true;
    }

    /// How far each pose of the problem was moved, against how far noise would move it, chi-squared with 6 degrees.
    [[nodiscard]] std::vector<double> surprises() const {
        std::vector<double> out;
        Eigen::Matrix<double, 6, 1> prior;
        prior.head<3>().setConstant(problem_.turn_sigma * problem_.turn_sigma);
        prior.tail<3>().setConstant(problem_.place_sigma * problem_.place_sigma);
        for (std::size_t i = 0; i < problem_.read.size(); ++i) {
            const auto off = pose_change(problem_.read[i], fit_.state.robot[i]);
            const Eigen::Matrix<double, 6, 1> unit = prior.cwiseSqrt().cwiseInverse();
            Eigen::Matrix<double, 6, 6> left =
                Eigen::Matrix<double, 6, 6>::Identity() -
                Eigen::Matrix<double, 6, 6>(unit.asDiagonal() * fit_.spread.own[i] * unit.asDiagonal());
            left.diagonal().array() += 1e-6;
            const Eigen::Matrix<double, 6, 1> z = unit.cwiseProduct(off);
            out.push_back(z.dot(left.ldlt().solve(z)));
        }
        return out;
    }

    [[nodiscard]] std::vector<double> sight_surprises() const {
        std::vector<double> out;
        for (const HandEyeSight& sight : problem_.sights) {
            out.push_back(sight_residual(fit_.state, sight).cwiseAbs2().dot(sight.weight));
        }
        return out;
    }

    /// Of the poses with the largest surprises, the one without which the rest fits best.
    void drop_pose(const std::vector<double>& surprise) {
        std::vector<std::size_t> order(surprise.size());
        for (std::size_t i = 0; i < order.size(); ++i) {
            order[i] = i;
        }
        std::ranges::sort(order, std::greater(), [&](std::size_t i) { return surprise[i]; });
        order.resize(std::min<std::size_t>(order.size(), 3));
        const std::vector<std::size_t> views = in_problem_;
        const HandEyeFit before = fit_;
        std::size_t best = order.front();
        HandEyeFit kept;
        double least = 1e300;
        for (const std::size_t i : order) {
            entries_[views[i]].used = false;
            fit_ = before;
            fit();
            if (fit_.chi_squared < least) {
                least = fit_.chi_squared;
                best = i;
                kept = fit_;
            }
            entries_[views[i]].used = true;
        }
        entries_[views[best]].used = false;
        result_.bad_poses.push_back(entries_[views[best]].view->name);
        build();
        fit_ = kept;
    }

    void drop_sight(std::size_t which) {
        const HandEyeSight& sight = problem_.sights[which];
        const std::size_t entry = in_problem_[static_cast<std::size_t>(sight.view)];
        const int id = ids_[static_cast<std::size_t>(sight.marker)];
        auto& view = views_[static_cast<std::size_t>(entries_[entry].view - views_.data())];
        const auto at = std::ranges::find(view.markers, id, &SeenMarker::id);
        result_.markers.push_back({.view = view.name, .line = at->line, .id = id});
        view.markers.erase(at);
        fit();
    }

    /// Names and leaves out what cannot be noise. False when there is too much of it.
    bool clean() {
        const std::size_t most = entries_.size() / 3;
        const std::size_t sights = problem_.sights.size();
        for (std::size_t round = 0;; ++round) {
            const std::vector<double> poses = surprises();
            const std::vector<double> seen = sight_surprises();
            const auto pose = std::ranges::max_element(poses);
            const auto sight = std::ranges::max_element(seen);
            const double of_pose = *pose / chi_squared_limit(6.0, kFalseAlarm / static_cast<double>(poses.size()));
            const double of_sight = *sight / chi_squared_limit(3.0, kFalseAlarm / static_cast<double>(seen.size()));
            if (std::max(of_pose, of_sight) <= 1.0) {
                return true;
            }
            const bool pose_is_worse = of_pose >= of_sight || poses_given_;
            if (pose_is_worse && of_pose <= 1.0) {
                return true;
            }
            if (result_.bad_poses.size() >= most || problem_.read.size() <= kLeastViews || round > sights / 4) {
                return false;
            }
            if (pose_is_worse) {
                drop_pose(poses);
            } else {
                drop_sight(static_cast<std::size_t>(sight - seen.begin()));
            }
        }
    }

    /// Noise by the middle of the views, which a bad pose does not move.
    void robust_ratio() {
        for (int round = 0; round < 6; ++round) {
            std::vector<double> poses = surprises();
            std::ranges::nth_element(poses, poses.begin() + static_cast<std::ptrdiff_t>(poses.size() / 2));
            const double robot = std::sqrt(poses[poses.size() / 2] / kMedian6);
            if (poses_given_) {
                result_.robot_ratio *= std::clamp(robot, 1e-2, 1e2);
                result_.marker_ratio = result_.robot_ratio;
                fit();
                continue;
            }
            std::vector<double> seen = sight_surprises();
            std::ranges::nth_element(seen, seen.begin() + static_cast<std::ptrdiff_t>(seen.size() / 2));
            // Whitened squares of three coordinates: median 2.37, less what the fit has taken.
            const double taken =
                std::clamp(redundancy_of_sights() / (3.0 * static_cast<double>(seen.size())), 0.05, 1.0);
            const double marker = std::sqrt(seen[seen.size() / 2] / (2.366 * taken));
            result_.robot_ratio *= std::clamp(robot, 1e-2, 1e2);
            result_.marker_ratio *= std::clamp(marker, 1e-2, 1e2);
            fit();
        }
    }

    [[nodiscard]] double redundancy() const {
        if (poses_given_) {  // markers that stand for a pose say six numbers a view; X and the target's place are
                             // twelve
            return std::max(6.0 * static_cast<double>(problem_.read.size()) - 12.0, 1.0);
        }
        return 3.0 * static_cast<double>(problem_.sights.size()) - 6.0 - 3.0 * problem_.markers;
    }
    [[nodiscard]] double redundancy_of_poses() const {
        double sum = 0.0;
        for (const auto& own : fit_.spread.own) {
            sum += 6.0 - own.diagonal().head<3>().sum() / (problem_.turn_sigma * problem_.turn_sigma) -
                   own.diagonal().tail<3>().sum() / (problem_.place_sigma * problem_.place_sigma);
        }
        return sum;
    }
    [[nodiscard]] double redundancy_of_sights() const { return redundancy() - redundancy_of_poses(); }

    /// Found noise over that of the present fit: robot, markers.
    [[nodiscard]] std::array<double, 2> ratios() const {
        if (poses_given_) {  // the noise of two poses that belong together cannot be told apart
            const double both = std::sqrt(fit_.chi_squared / redundancy());
            return {both, both};
        }
        double poses = 0.0;
        for (std::size_t i = 0; i < problem_.read.size(); ++i) {
            const auto off = pose_change(problem_.read[i], fit_.state.robot[i]);
            poses += off.head<3>().squaredNorm() / (problem_.turn_sigma * problem_.turn_sigma) +
                     off.tail<3>().squaredNorm() / (problem_.place_sigma * problem_.place_sigma);
        }
        const double of_poses = redundancy_of_poses();
        const double of_sights = redundancy_of_sights();
        return {of_poses > 1.0 ? std::sqrt(poses / of_poses) : 1.0,
                of_sights > 1.0 ? std::sqrt(std::max(fit_.chi_squared - poses, 0.0) / of_sights) : 1.0};
    }

    void fit_noise() {
        for (int round = 0; round < 20; ++round) {
            const auto found = ratios();
            result_.robot_ratio *= std::clamp(found[0], 0.05, 20.0);
            result_.marker_ratio *= std::clamp(found[1], 0.05, 20.0);
            fit();
            if (std::abs(found[0] - 1.0) < 0.01 && std::abs(found[1] - 1.0) < 0.01) {
                return;
            }
        }
    }

    void fit_all() {
        fit();
        refuse_blind(true);
        if (noise_.fit) {
            robust_ratio();
        }
        if (options_.find_wrong && !clean()) {
            result_.notes.emplace_back(
                "too many poses do not fit the noise stated: all are kept, and the noise is taken from the data");
            result_.bad_poses.clear();
            for (HandEyeEntry& entry : entries_) {
                entry.used = true;
            }
            fit();
            noise_.fit = true;
        }
        if (noise_.fit) {
            fit_noise();
        }
        refuse_blind(false);
    }

    /// Uncertainty of turn and place, each in its worst direction, in f.
    void find_blind() {
        const Eigen::Matrix<double, 6, 6> s = fit_.spread.common.topLeftCorner<6, 6>();
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> turn(Eigen::Matrix3d(s.topLeftCorner<3, 3>()));
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> place(Eigen::Matrix3d(s.bottomRightCorner<3, 3>()));
        result_.turn_sigma = std::sqrt(turn.eigenvalues()[2]);
        result_.place_sigma = std::sqrt(place.eigenvalues()[2]);
        result_.least_turn = to_vec(turn.eigenvectors().col(2));
        result_.least_place = to_vec(place.eigenvectors().col(2));
    }

    void refuse_blind(bool by_motion) {
        find_blind();
        const auto vector = [](const Vec3& v) { return fmt::format("({:.2f}, {:.2f}, {:.2f})", v.x, v.y, v.z); };
        // A person gets the reason by the motions where that is plain, and else by the covariance.
        const bool unsure = !(result_.turn_sigma <= options_.most_turn && result_.place_sigma <= options_.most_place);
        if (by_motion && unsure) {
            const Vec3 about = to_vec(start_.turned_about.col(0));
            if (start_.turned[0] < kFewTurns) {
                refuse(
                    "the robot moved without turning: where the sensor sits on the flange is not seen in any direction",
                    fmt::format("turned by {:.2f} deg rms", start_.turned[0] / 2.0 / kDegree),
                    "add poses that are tilted by 15 deg or more about two axes");
            }
            if (start_.turned[1] < 0.05 * start_.turned[0]) {
                refuse(
                    "the robot turned about one axis of the flange alone: the sensor's place along that axis is not "
                    "seen",
                    vector(about), "add poses that are tilted by 15 deg or more about other axes");
            }
        }
        if (by_motion || !unsure) {
            return;
        }
        if (!(result_.place_sigma <= options_.most_place)) {
            refuse(fmt::format(
                       "the poses do not show the sensor's place along a direction of the flange (1 sigma: {:.3g} mm)",
                       result_.place_sigma * 1e3),
                   vector(result_.least_place), "add poses that turn about axes across it, or give more views");
        }
        refuse(
            fmt::format("the poses do not show the sensor's turn about a direction of the flange (1 sigma: {:.3g} deg)",
                        result_.turn_sigma / kDegree),
            vector(result_.least_turn), "add poses that turn about axes across it, or give more views");
    }

    void take_covariance() {
        double scale = 1.0;
        result_.chi_squared = fit_.chi_squared;
        result_.freedom = redundancy();
        if (noise_.fit) {
            result_.notes.push_back(fmt::format(
                "noise found in the data: {:.3g} times that stated for the robot, {:.3g} for {}", result_.robot_ratio,
                result_.marker_ratio, poses_given_ ? "the target's poses" : "markers"));
        } else {
            const auto found = ratios();
            result_.robot_ratio = found[0];
            result_.marker_ratio = found[1];
            if (result_.chi_squared > chi_squared_limit(result_.freedom, 1e-3)) {
                scale = result_.chi_squared / result_.freedom;
                result_.notes.push_back(
                    fmt::format("the data scatter more than the noise stated allows (robot {:.2f} times, markers "
                                "{:.2f} times): the "
                                "uncertainty is raised by {:.2f}",
                                found[0], found[1], std::sqrt(scale)));
            }
        }
        Eigen::Matrix<double, 6, 6> plain = scale * fit_.spread.common.topLeftCorner<6, 6>();
        Eigen::Matrix<double, 6, 6> to_xi = Eigen::Matrix<double, 6, 6>::Identity();
        to_xi.bottomLeftCorner<3, 3>() = skew(fit_.state.x.t);
        Eigen::Matrix<double, 6, 6> xi = to_xi * plain * to_xi.transpose();
        plain = (0.5 * (plain + plain.transpose())).eval();
        xi = (0.5 * (xi + xi.transpose())).eval();
        for (int r = 0; r < 6; ++r) {
            for (int c = 0; c < 6; ++c) {
                result_.by_value.at[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] = plain(r, c);
                result_.covariance.at[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] = xi(r, c);
            }
        }
        result_.turn_sigma *= std::sqrt(scale);
        result_.place_sigma *= std::sqrt(scale);
    }

    /// The pose that the markers of a view ask for, with all else as fitted.
    [[nodiscard]] Motion pose_of_markers(const HandEyeEntry& entry) const {
        std::vector<PlacePair> pairs;
        for (const SeenMarker& m : entry.view->markers) {
            const auto at = std::ranges::find(ids_, m.id);
            if (at != ids_.end()) {
                pairs.push_back({fit_.state.at[static_cast<std::size_t>(at - ids_.begin())],
                                 fit_.state.x * to_eigen(m.place), 1.0});
            }
        }
        return fit_motion(pairs);
    }

    void report_views() {
        const std::vector<double> surprise = surprises();
        std::map<std::size_t, std::size_t> at;
        for (std::size_t i = 0; i < in_problem_.size(); ++i) {
            at[in_problem_[i]] = i;
        }
        for (std::size_t i = 0; i < entries_.size(); ++i) {
            const HandEyeEntry& entry = entries_[i];
            HandEyeViewResult out{.name = entry.view->name, .used = entry.used, .markers = entry.view->markers.size()};
            const Motion read = result_.robot_inverted ? entry.f.inverse() : entry.f;
            const Motion now = entry.used ? fit_.state.robot[at[i]] : pose_of_markers(entry);
            const auto off = pose_change(read, now);
            out.turn_off = off.head<3>().norm();
            out.place_off = off.tail<3>().norm();
            if (entry.used) {
                out.surprise = surprise[at[i]];
                double sum = 0.0;
                for (const HandEyeSight& sight : problem_.sights) {
                    sum +=
                        sight.view == static_cast<int>(at[i]) ? sight_residual(fit_.state, sight).squaredNorm() : 0.0;
                }
                out.marker_rms = std::sqrt(sum / (3.0 * static_cast<double>(out.markers)));
            } else {
                out.surprise = off.head<3>().squaredNorm() / (problem_.turn_sigma * problem_.turn_sigma) +
                               off.tail<3>().squaredNorm() / (problem_.place_sigma * problem_.place_sigma);
            }
            result_.views.push_back(out);
        }
    }

    /// What plain residuals would say: the fit's X and the poses as read.
    [[nodiscard]] double scatter() const {
        const HandEyeState plain = start_state(problem_, fit_.state.x);
        double sum = 0.0;
        for (const HandEyeSight& sight : problem_.sights) {
            sum += sight_residual(plain, sight).squaredNorm();
        }
        return std::sqrt(sum / static_cast<double>(problem_.sights.size()));
    }

    /// The same for a target given as poses: its origin alone, for the markers stand wherever the noise puts them.
    [[nodiscard]] double pose_scatter() const {
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();
        std::vector<Eigen::Vector3d> places;
        for (const std::size_t i : in_problem_) {
            const Motion f = result_.robot_inverted ? entries_[i].f.inverse() : entries_[i].f;
            const Motion c = result_.target_inverted ? entries_[i].c.inverse() : entries_[i].c;
            places.push_back((f * fit_.state.x * c).t);
            mean += places.back();
        }
        mean /= static_cast<double>(places.size());
        double sum = 0.0;
        for (const Eigen::Vector3d& p : places) {
            sum += (p - mean).squaredNorm();
        }
        return std::sqrt(sum / static_cast<double>(places.size()));
    }

    HandEyeResult finish() {
        take_covariance();
        result_.f_from_c = {to_mat(fit_.state.x.r), to_vec(fit_.state.x.t)};
        result_.scatter_rms = poses_given_ ? pose_scatter() : scatter();
        report_views();
        return std::move(result_);
    }

    std::filesystem::path file_;
    std::vector<HandEyeView> views_;
    HandEyeOptions options_;
    HandEyeNoise noise_;
    bool poses_given_ = false;
    HandEyeResult result_;
    std::vector<HandEyeEntry> entries_;
    HandEyeStart start_;
    HandEyeProblem problem_;
    std::vector<std::size_t> in_problem_;  ///< entry of each view of the problem
    std::vector<int> ids_;                 ///< of its markers
    HandEyeFit fit_;
    bool fitted_ = false;
};

}  // namespace

HandEyeResult calibrate_hand_eye(const std::filesystem::path& file, std::vector<HandEyeView> views,
                                 const HandEyeOptions& options) {
    return HandEye(file, std::move(views), options).run();
}

}  // namespace sc::host
