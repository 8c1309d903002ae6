// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "host/registration/chain_problem.hpp"

namespace sc::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kOddRobot = 3.0;  ///< noise of that many times what is stated is worth a word

template <int N>
Covariance<static_cast<std::size_t>(N)> covariance_of(const Eigen::Matrix<double, N, N>& m) {
    Covariance<static_cast<std::size_t>(N)> out;
    for (int r = 0; r < N; ++r) {
        for (int c = 0; c < N; ++c) {
            out.at[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] = 0.5 * (m(r, c) + m(c, r));
        }
    }
    return out;
}

struct Worst {
    double sigma = 0.0;
    Eigen::Vector3d direction;
};
Worst worst_of(const Eigen::Matrix3d& covariance) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance);
    return {std::sqrt(std::max(axes.eigenvalues()[2], 0.0)), axes.eigenvectors().col(2)};
}
std::string text_of(const Eigen::Vector3d& v) { return fmt::format("({:.2f}, {:.2f}, {:.2f})", v[0], v[1], v[2]); }

class Result {
public:
    Result(const ChainInput& input, const ChainOptions& options, const ChainProblem& problem,
           const ChainSystem::Spread* spread)
        : input_(input),
          options_(options),
          problem_(problem),
          model_(problem.model),
          state_(problem.state),
          spread_(spread) {}

    ChainResult run() {
        out_.findings = problem_.findings;
        out_.notes = problem_.notes;
        out_.robot_ratio = problem_.robot_ratio;
        judge();
        views();
        markers();
        residuals();
        transform();
        axis();
        for (const ChainPrediction& p : options_.predict) {
            predict(p);
        }
        note_robot();
        return std::move(out_);
    }

private:
    [[nodiscard]] double scale() const { return out_.raised * out_.raised; }

    /// Sum of squares, freedom, and whether the data scatter more than they say.
    void judge() {
        double squares = 0.0;
        double count = 0.0;
        double pointed_squares = 0.0;
        double pointed = 0.0;
        std::vector<bool> seen(model_.turning.size(), false);
        double chi_squared = 0.0;
        for (std::size_t i = 0; i < model_.sights.size(); ++i) {
            const ChainSight& s = model_.sights[i];
            if (!s.used) {
                continue;
            }
            const Eigen::Vector3d r = chain_residual(model_, state_, s);
            chi_squared += r.cwiseAbs2().dot(s.weight);
            (problem_.origins[i].pointed ? pointed_squares : squares) += r.squaredNorm();
            (problem_.origins[i].pointed ? pointed : count) += 3.0;
            seen[s.marker] = true;
        }
        out_.rms = std::sqrt(squares / std::max(count, 1.0));
        out_.pointing_rms = std::sqrt(pointed_squares / std::max(pointed, 1.0));
        out_.chi_squared = spread_ != nullptr ? problem_.chi_squared : chi_squared;
        out_.freedom = count + pointed + 3.0 * static_cast<double>(model_.known.size()) +
                       6.0 * static_cast<double>(model_.reads.size()) - static_cast<double>(model_.common()) -
                       3.0 * static_cast<double>(std::ranges::count(seen, true)) + (model_.known.empty() ? 6.0 : 0.0);
        for (const bool wrong : problem_.turn_wrong) {
            out_.freedom += wrong ? 0.0 : 1.0;
        }
        if (out_.freedom >= 1.0 && out_.chi_squared > chi_squared_limit(std::max(out_.freedom, 2.0), 1e-3)) {
            out_.raised = std::sqrt(out_.chi_squared / out_.freedom);
            out_.notes.push_back(
                fmt::format("the data scatter more than stated: all uncertainties are raised by {:.2f}", out_.raised));
        }
    }

    void views() {
        for (std::size_t i = 0; i < input_.views.size(); ++i) {
            ChainViewResult view;
            view.name = input_.views[i].seen.view;
            view.rotation = to_mat(state_.pose[i].r);
            view.translation = to_vec(state_.pose[i].t);
            const std::size_t stop = problem_.stop_of[i];
            view.turn = model_.stops[stop].turn;
            view.turn_off = state_.off[stop];
            view.turn_wrong = problem_.turn_wrong[stop];
            double squares = 0.0;
            Eigen::Vector3d middle = Eigen::Vector3d::Zero();
            for (std::size_t k = 0; k < model_.sights.size(); ++k) {
                const ChainSight& s = model_.sights[k];
                if (s.used && !problem_.origins[k].pointed && s.pose == i) {
                    squares += chain_residual(model_, state_, s).squaredNorm();
                    middle += state_.pose[i] * s.place;
                    ++view.markers;
                }
            }
            view.rms = std::sqrt(squares / std::max(3.0 * static_cast<double>(view.markers), 1.0));
            middle /= std::max(static_cast<double>(view.markers), 1.0);
            if (spread_ != nullptr) {
                view_spread(i, middle, view);
            }
            const auto read = std::ranges::find(model_.reads, i, &ChainRead::pose);
            if (read != model_.reads.end()) {
                const auto off = read_residual(state_, *read);
                view.robot = true;
                view.robot_turn_off = off.head<3>().norm();
                view.robot_off = off.tail<3>().norm();
            }
            out_.views.push_back(view);
        }
    }
    void view_spread(std::size_t i, const Eigen::Vector3d& middle, ChainViewResult& view) const {
        const Eigen::Matrix<double, 6, 6> pose =
            scale() * spread_->common().block<6, 6>(model_.pose_at(i), model_.pose_at(i));
        Eigen::Matrix<double, 3, 6> there;
        there << -skew(middle - state_.pose[i].t), Eigen::Matrix3d::Identity();
        const Worst turn = worst_of(pose.topLeftCorner<3, 3>());
        const Worst place = worst_of(there * pose * there.transpose());
        view.turn_sigma = turn.sigma;
        view.place_sigma = place.sigma;
        const int line = input_.views[i].seen.line;
        if (!(turn.sigma <= options_.most_turn)) {
            refuse_chain(
                input_, line,
                fmt::format("the markers of view {} do not show its turn about a direction (1 sigma: {:.3g} deg)",
                            view.name, turn.sigma / kDegree),
                text_of(turn.direction), "see more markers in it, spread across that direction");
        }
        if (!(place.sigma <= options_.most_place)) {
            refuse_chain(
                input_, line,
                fmt::format("the markers of view {} do not show its place along a direction (1 sigma: {:.3g} mm)",
                            view.name, place.sigma * 1e3),
                text_of(place.direction), "see more markers in it");
        }
    }

    void markers() {
        for (std::size_t m = 0; m < model_.turning.size(); ++m) {
            ChainMarkerResult marker{
                .id = problem_.ids[m], .turns = model_.turning[m], .place = to_vec(state_.at[m]), .covariance = {}};
            double squares = 0.0;
            for (const ChainSight& s : model_.sights) {
                if (s.marker == m) {
                    marker.seen += s.used ? 1 : 0;
                    marker.wrong += s.used ? 0 : 1;
                    squares += s.used ? chain_residual(model_, state_, s).squaredNorm() : 0.0;
                }
            }
            marker.rms = std::sqrt(squares / std::max(3.0 * static_cast<double>(marker.seen), 1.0));
            if (spread_ != nullptr) {
                marker.covariance = covariance_of<3>(scale() * spread_->marker(m));
            }
            if (marker.seen > 0) {
                out_.markers.push_back(marker);
            }
        }
    }

    void residuals() {
        for (std::size_t k = 0; k < model_.sights.size(); ++k) {
            const ChainSight& s = model_.sights[k];
            const SightOrigin& from = problem_.origins[k];
            const double turn = model_.stops[s.stop].turn + state_.off[s.stop];
            out_.residuals.push_back(
                {.view = from.pointed ? std::string() : input_.views[from.view].seen.view,
                 .id = problem_.ids[s.marker],
                 .place = to_vec(chain_place(state_, model_.turning[s.marker], state_.at[s.marker], turn)),
                 .residual = to_vec(state_.pose[s.pose].r * chain_residual(model_, state_, s)),
                 .used = s.used});
        }
    }

    [[nodiscard]] Motion h_from_c() const { return state_.pose[*problem_.h_pose].inverse(); }

    void transform() {
        if (!problem_.h_pose) {
            return;
        }
        const Motion h = h_from_c();
        out_.h_from_c = ChainResult::Transform{to_mat(h.r), to_vec(h.t), {}};
        if (spread_ == nullptr) {
            return;
        }
        // The pose is c_from_h, moved by (w, d): ξ = −Rᵀ(w, d) with its rotation R.
        const Eigen::Index at = model_.pose_at(*problem_.h_pose);
        Eigen::Matrix<double, 6, 6> j = Eigen::Matrix<double, 6, 6>::Zero();
        j.topLeftCorner<3, 3>() = -h.r;
        j.bottomRightCorner<3, 3>() = -h.r;
        const Eigen::Matrix<double, 6, 6> xi = scale() * j * spread_->common().block<6, 6>(at, at) * j.transpose();
        out_.h_from_c->covariance = covariance_of<6>(xi);
        const Worst turn = worst_of(xi.topLeftCorner<3, 3>());
        if (!(turn.sigma <= options_.most_turn)) {
            refuse_chain(
                input_, 0,
                fmt::format("the places pointed at do not show the turn of h_from_c about a direction (1 sigma: "
                            "{:.3g} deg)",
                            turn.sigma / kDegree),
                text_of(turn.direction), "point at markers further apart across that direction");
        }
    }

    void axis() {
        if (!model_.has_axis) {
            out_.axis = input_.axis ? std::optional(ChainResult::Axis{input_.axis->point, input_.axis->direction})
                                    : std::nullopt;
            return;
        }
        // The point of the axis beside the middle of what turns.
        Eigen::Vector3d middle = Eigen::Vector3d::Zero();
        double count = 0.0;
        for (const ChainSight& s : model_.sights) {
            if (s.used && model_.turning[s.marker]) {
                middle += state_.at[s.marker];
                count += 1.0;
            }
        }
        middle /= std::max(count, 1.0);
        const Eigen::Vector3d u = state_.direction;
        const Eigen::Vector3d point = state_.point + u * u.dot(middle - state_.point);
        out_.axis = ChainResult::Axis{to_vec(point), to_vec(u)};
        if (spread_ == nullptr) {
            axis_in_h(point);
            return;
        }
        Eigen::Matrix4d to_point = Eigen::Matrix4d::Identity();  // from the model's point to this one
        to_point.topRightCorner<2, 2>() = u.dot(point - state_.point) * Eigen::Matrix2d::Identity();
        const Eigen::Matrix4d spread = scale() * to_point *
                                       spread_->common().block<4, 4>(model_.axis_at(), model_.axis_at()) *
                                       to_point.transpose();
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> place(Eigen::Matrix2d(spread.topLeftCorner<2, 2>()));
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> turn(Eigen::Matrix2d(spread.bottomRightCorner<2, 2>()));
        out_.axis->place_sigma = std::sqrt(place.eigenvalues()[1]);
        out_.axis->turn_sigma = std::sqrt(turn.eigenvalues()[1]);
        if (!(out_.axis->turn_sigma <= options_.most_turn) || !(out_.axis->place_sigma <= options_.most_place)) {
            const Eigen::Vector3d blind = state_.across * turn.eigenvectors().col(1);
            refuse_chain(input_, 0,
                         fmt::format("the markers on the table do not show its axis (1 sigma: {:.3g} deg, {:.3g} mm); "
                                     "least certain towards",
                                     out_.axis->turn_sigma / kDegree, out_.axis->place_sigma * 1e3),
                         text_of(blind), "give angles over 60 deg or more, and markers away from the axis");
        }
        axis_in_h(point);
        axis_spread(point);
    }

    void axis_in_h(const Eigen::Vector3d& point) {
        if (!problem_.h_pose) {
            return;
        }
        const Motion h = h_from_c();
        const Eigen::Vector3d u = h.r * state_.direction;
        if (u[2] < 0.3) {
            refuse_chain(input_, 0,
                         "the table's axis does not point up in h: its angles count clockwise, or z of h is not up",
                         text_of(u), "give C counter-clockwise seen from +z");
        }
        out_.axis_in_h = ChainResult::AxisInH{AxisLine{{to_vec(h * point)}, {to_vec(u)}}, {}};
    }

    /// Of ξ of h_from_c with where the axis meets the plane z = point.z of h and its direction.
    void axis_spread(const Eigen::Vector3d& point) {
        if (!problem_.h_pose) {
            return;
        }
        const Motion h = h_from_c();
        const Motion& pose = state_.pose[*problem_.h_pose];
        const Eigen::Vector3d u = state_.direction;
        const Eigen::Vector3d u_h = h.r * u;
        Eigen::Matrix<double, 10, 10> j = Eigen::Matrix<double, 10, 10>::Zero();  // by w, d of the pose, then the axis
        j.block<3, 3>(0, 0) = -h.r;
        j.block<3, 3>(3, 3) = -h.r;
        Eigen::Matrix<double, 3, 10> place = Eigen::Matrix<double, 3, 10>::Zero();
        place.leftCols<3>() = h.r * skew(point - pose.t);
        place.middleCols<3>(3) = -h.r;
        place.middleCols<2>(6) = h.r * state_.across;
        place.rightCols<2>() = u.dot(point - state_.point) * h.r * state_.across;
        Eigen::Matrix<double, 3, 10> direction = Eigen::Matrix<double, 3, 10>::Zero();
        direction.leftCols<3>() = h.r * skew(u);
        direction.rightCols<2>() = h.r * state_.across;
        for (Eigen::Index k = 0; k < 2; ++k) {
            j.row(6 + k) = place.row(k) - (u_h[k] / u_h[2]) * place.row(2);
            j.row(8 + k) = direction.row(k);
        }
        std::vector<Eigen::Index> at;
        for (Eigen::Index i = 0; i < 6; ++i) {
            at.push_back(model_.pose_at(*problem_.h_pose) + i);
        }
        for (Eigen::Index i = 0; i < 4; ++i) {
            at.push_back(model_.axis_at() + i);
        }
        const Eigen::Matrix<double, 10, 10> spread = scale() * j * spread_->common()(at, at) * j.transpose();
        out_.together = covariance_of<10>(spread);
        out_.axis_in_h->covariance = covariance_of<4>(spread.bottomRightCorner<4, 4>());
    }

    void predict(const ChainPrediction& asked) {
        const auto found = std::ranges::find(problem_.ids, asked.id);
        if (found == problem_.ids.end() || !problem_.h_pose) {
            return;
        }
        const auto m = static_cast<std::size_t>(found - problem_.ids.begin());
        const double turn = -asked.face_deg * kDegree;
        const Eigen::Vector3d q = chain_place(state_, model_.turning[m], state_.at[m], turn);
        ChainPlace place{asked.id, asked.face_deg, to_vec(h_from_c() * q), {}};
        if (spread_ != nullptr) {
            const ChainSlope slope = chain_slope(model_, state_, *problem_.h_pose, m, turn, std::nullopt);
            Eigen::Matrix3d spread = scale() * spread_->of(m, slope.parts, slope.own);
            spread += options_.table * options_.table * slope.by_turn * slope.by_turn.transpose();
            spread.diagonal().array() += options_.axes * options_.axes;
            place.covariance = covariance_of<3>(spread);
        }
        out_.places.push_back(place);
    }

    void note_robot() {
        if (options_.robot == RobotUse::weighed && problem_.robot_ratio > kOddRobot) {
            double squares = 0.0;
            double count = 0.0;
            for (const ChainViewResult& v : out_.views) {
                squares += v.robot ? v.robot_off * v.robot_off : 0.0;
                count += v.robot ? 1.0 : 0.0;
            }
            out_.notes.push_back(
                fmt::format("robot poses are off by {:.3f} mm rms, {:.0f} times their noise: they count for so little",
                            1e3 * std::sqrt(squares / std::max(count, 1.0)), problem_.robot_ratio));
        }
    }

    const ChainInput& input_;
    const ChainOptions& options_;
    const ChainProblem& problem_;
    const ChainModel& model_;
    const ChainState& state_;
    const ChainSystem::Spread* spread_;
    ChainResult out_;
};

}  // namespace

ChainResult chain_result(const ChainInput& input, const ChainOptions& options, const ChainProblem& problem,
                         const ChainSystem::Spread* spread) {
    return Result(input, options, problem, spread).run();
}

}  // namespace sc::host
