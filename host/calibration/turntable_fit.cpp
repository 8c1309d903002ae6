// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/turntable_fit.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "host/calibration/bordered_system.hpp"
#include "host/calibration/motion.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kFalseAlarm = 1e-4;
constexpr double kLeastArc = 1.0 * kDegree;

using System = BorderedSystem<1>;

struct Sight {
    std::size_t view = 0;
    std::size_t marker = 0;
    Eigen::Vector3d place;
    Eigen::Vector3d weight;
    bool used = true;
};
struct State {
    Eigen::Vector3d point;
    Eigen::Vector3d direction;
    Eigen::Matrix<double, 3, 2> across;  ///< with the direction, a right-handed frame
    std::vector<Eigen::Vector3d> at;     ///< markers at angle 0
    std::vector<double> off;             ///< true angle less reading
};

Eigen::Matrix<double, 3, 2> across_of(const Eigen::Vector3d& direction) {
    Eigen::Matrix<double, 3, 2> out;
    const Eigen::Vector3d other = std::abs(direction[0]) < 0.6 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
    out.col(0) = direction.cross(other).normalized();
    out.col(1) = direction.cross(out.col(0));
    return out;
}

class Turntable {
public:
    Turntable(const std::filesystem::path& file, std::vector<MarkerView> views, const TurntableOptions& options,
              bool as_poses)
        : file_(file), views_(std::move(views)), options_(options), as_poses_(as_poses) {}

    TurntableFit run() {
        prepare();
        start();
        fit();
        clean();
        if (options_.fit_noise) {
            for (int round = 0; round < 10; ++round) {
                const double found = std::sqrt(chi_squared_ / freedom());
                ratio_ *= std::clamp(found, 1e-3, 1e3);
                fit();
                if (std::abs(found - 1.0) < 0.01) {
                    break;
                }
            }
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

    void prepare() {
        for (const MarkerView& view : views_) {
            if (!view.turn) {
                throw InputError({.file = file_.string(),
                                  .line = view.line,
                                  .problem = "view has no angle of the table",
                                  .value = view.view,
                                  .action = "give a column turn_deg or turn_rad"});
            }
            angle_.push_back(*view.turn);
        }
        const auto [least, most] = std::ranges::minmax(angle_);
        result_.arc = most - least;
        if (result_.arc < kLeastArc || views_.size() < 3) {
            refuse("the table has hardly turned: the axis is not seen",
                   fmt::format("{} angles over {:.3f} deg", views_.size(), result_.arc / kDegree),
                   "give three angles or more, over 60 deg or more");
        }
        if (options_.find_wrong && !as_poses_) {
            result_.markers = check_markers(views_, options_.sigma);
        }
        std::map<int, std::size_t> index;
        for (std::size_t i = 0; i < views_.size(); ++i) {
            for (const SeenMarker& m : views_[i].markers) {
                const auto [at, added] = index.try_emplace(m.id, index.size());
                if (added) {
                    ids_.push_back(m.id);
                }
                Eigen::Vector3d sigma = to_eigen(m.sigma);
                if (sigma.maxCoeff() <= 0.0) {
                    sigma.setConstant(options_.sigma);
                }
                sights_.push_back({i, at->second, to_eigen(m.place), sigma.cwiseAbs2().cwiseInverse(), true});
            }
        }
        view_used_.assign(views_.size(), true);
    }

    [[nodiscard]] std::map<std::size_t, Eigen::Vector3d> seen_by(std::size_t view) const {
        std::map<std::size_t, Eigen::Vector3d> out;
        for (const Sight& s : sights_) {
            if (s.view == view) {
                out[s.marker] = s.place;
            }
        }
        return out;
    }

    /// From the rigid motions between views, each with three markers or more; zero where there are none.
    [[nodiscard]] Eigen::Vector3d direction_by_motions() const {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (std::size_t i = 0; i < views_.size(); ++i) {
            const auto a = seen_by(i);
            for (std::size_t j = 0; j < i; ++j) {
                std::vector<PlacePair> pairs;
                for (const auto& [marker, place] : seen_by(j)) {
                    if (const auto at = a.find(marker); at != a.end()) {
                        pairs.push_back({at->second, place, 1.0});
                    }
                }
                if (pairs.size() >= 3) {
                    sum += std::sin(angle_[i] - angle_[j]) * axial(fit_motion(pairs).r);
                }
            }
        }
        return sum;
    }

    /// Each marker runs on a + b cos + c sin, with b × c along the axis: linear in a, b and c.
    [[nodiscard]] Eigen::Vector3d direction_by_circles() const {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (std::size_t k = 0; k < ids_.size(); ++k) {
            Eigen::Matrix3d left = Eigen::Matrix3d::Zero();
            Eigen::Matrix3d right = Eigen::Matrix3d::Zero();
            for (const Sight& s : sights_) {
                if (s.marker == k) {
                    const Eigen::Vector3d row(1.0, std::cos(angle_[s.view]), std::sin(angle_[s.view]));
                    left += row * row.transpose();
                    right += row * s.place.transpose();
                }
            }
            const Eigen::LDLT<Eigen::Matrix3d> solver(left);
            if (solver.rcond() > 1e-12) {
                const Eigen::Matrix3d abc = solver.solve(right);
                sum += Eigen::Vector3d(abc.row(1)).cross(Eigen::Vector3d(abc.row(2)));
            }
        }
        return sum;
    }

    void start() {
        Eigen::Vector3d direction = direction_by_motions();
        if (direction.norm() < 1e-9) {
            direction = direction_by_circles();
        }
        if (direction.norm() < 1e-12) {
            refuse("the markers do not move with the table: the axis's direction is not seen",
                   fmt::format("{} markers", ids_.size()),
                   "take markers away from the axis, seen at three angles or more");
        }
        state_.direction = direction.normalized();
        state_.across = across_of(state_.direction);
        // The point: what all turns by the differences of angles leave where it is.
        Eigen::Matrix3d left = Eigen::Matrix3d::Zero();
        Eigen::Vector3d right = Eigen::Vector3d::Zero();
        Eigen::Vector3d middle = Eigen::Vector3d::Zero();
        for (const Sight& a : sights_) {
            middle += a.place / static_cast<double>(sights_.size());
            for (const Sight& b : sights_) {
                if (a.marker == b.marker && b.view < a.view) {
                    const Eigen::Matrix3d turn = exp_turn((angle_[a.view] - angle_[b.view]) * state_.direction);
                    const Eigen::Matrix3d m = turn - Eigen::Matrix3d::Identity();
                    left += m.transpose() * m;
                    right += m.transpose() * (turn * b.place - a.place);
                }
            }
        }
        const Eigen::Matrix2d in_plane = state_.across.transpose() * left * state_.across;
        const Eigen::Vector2d at = in_plane.ldlt().solve(Eigen::Vector2d(state_.across.transpose() * right));
        state_.point = state_.across * at + state_.direction * state_.direction.dot(middle);
        state_.off.assign(views_.size(), 0.0);
        state_.at.assign(ids_.size(), Eigen::Vector3d::Zero());
        std::vector<double> count(ids_.size(), 0.0);
        for (const Sight& s : sights_) {
            state_.at[s.marker] +=
                state_.point + exp_turn(-angle_[s.view] * state_.direction) * (s.place - state_.point);
            count[s.marker] += 1.0;
        }
        for (std::size_t k = 0; k < count.size(); ++k) {
            state_.at[k] /= count[k];
        }
    }

    [[nodiscard]] Eigen::Matrix3d turn_of(const State& state, std::size_t view) const {
        return exp_turn((angle_[view] + state.off[view]) * state.direction);
    }
    [[nodiscard]] Eigen::Vector3d residual(const State& state, const Sight& s) const {
        return s.place - state.point - turn_of(state, s.view) * (state.at[s.marker] - state.point);
    }
    /// A view whose angle is not believed keeps its markers, and finds its angle by them.
    [[nodiscard]] double table_weight(std::size_t view) const {
        const double sigma = (view_used_[view] ? options_.table : 1.0) * ratio_;
        return 1.0 / (sigma * sigma);
    }

    [[nodiscard]] double cost(const State& state) const {
        double sum = 0.0;
        for (const Sight& s : sights_) {
            if (s.used) {
                sum += residual(state, s).cwiseAbs2().dot(s.weight) / (ratio_ * ratio_);
            }
        }
        for (std::size_t i = 0; i < views_.size(); ++i) {
            sum += table_weight(i) * state.off[i] * state.off[i];
        }
        return sum;
    }

    [[nodiscard]] System system(const State& state) const {
        System out(4 + 3 * static_cast<Eigen::Index>(ids_.size()), views_.size());
        for (const Sight& s : sights_) {
            if (!s.used) {
                continue;
            }
            const Eigen::Matrix3d turn = turn_of(state, s.view);
            const Eigen::Vector3d arm = state.at[s.marker] - state.point;
            const double angle = angle_[s.view] + state.off[s.view];
            std::array<System::Part, 2> parts;
            parts[0].at = 0;
            parts[0].jacobian.resize(3, 4);
            for (Eigen::Index i = 0; i < 2; ++i) {
                const Eigen::Vector3d u = state.across.col(i);
                parts[0].jacobian.col(i) = u - turn * u;
                parts[0].jacobian.col(2 + i) =
                    std::sin(angle) * u.cross(arm) +
                    (1.0 - std::cos(angle)) * (u * state.direction.dot(arm) + state.direction * u.dot(arm));
            }
            parts[1].at = 4 + 3 * static_cast<Eigen::Index>(s.marker);
            parts[1].jacobian = turn;
            const Eigen::Vector3d by_angle = state.direction.cross(turn * arm);
            out.add(s.view, residual(state, s), s.weight / (ratio_ * ratio_), parts, by_angle);
        }
        for (std::size_t i = 0; i < views_.size(); ++i) {
            out.add_prior(i, System::ViewVector::Constant(-state.off[i]),
                          System::ViewVector::Constant(table_weight(i)));
        }
        return out;
    }

    static State moved(const State& state, const System::Step& step) {
        State next = state;
        next.point += state.across * step.common.head<2>();
        next.direction = (state.direction + state.across * step.common.segment<2>(2)).normalized();
        next.across = across_of(next.direction);
        for (std::size_t k = 0; k < next.at.size(); ++k) {
            next.at[k] += step.common.segment<3>(4 + 3 * static_cast<Eigen::Index>(k));
        }
        for (std::size_t i = 0; i < next.off.size(); ++i) {
            next.off[i] += step.own[i][0];
        }
        return next;
    }

    void fit() {
        chi_squared_ =
            minimise(state_, [&](const State& s) { return system(s); }, [&](const State& s) { return cost(s); }, moved);
        spread_ = system(state_).covariance();
    }

    /// Poses as markers say six numbers a view; the axis has four unknowns, the target's pose six.
    [[nodiscard]] double freedom() const {
        const auto free_angles = static_cast<double>(std::ranges::count(view_used_, false));
        if (as_poses_) {
            return std::max(6.0 * static_cast<double>(views_.size()) - 10.0 - free_angles, 1.0);
        }
        const auto used = static_cast<double>(std::ranges::count(sights_, true, &Sight::used));
        return std::max(3.0 * used - 4.0 - 3.0 * static_cast<double>(ids_.size()) - free_angles, 1.0);
    }

    /// Angles read wrong and markers that no noise explains, the worst first.
    void clean() {
        if (!options_.find_wrong || options_.fit_noise) {
            return;
        }
        const std::size_t most = views_.size() / 3;
        std::size_t angles = 0;
        const double angle_limit = chi_squared_limit(2.0, kFalseAlarm / static_cast<double>(views_.size()));
        const double sight_limit = chi_squared_limit(3.0, kFalseAlarm / static_cast<double>(sights_.size()));
        for (std::size_t round = 0; round < views_.size() + sights_.size() / 4; ++round) {
            double worst = 1.0;
            std::ptrdiff_t view = -1;
            std::ptrdiff_t sight = -1;
            for (std::size_t i = 0; i < views_.size(); ++i) {
                const double left = 1.0 / table_weight(i) - spread_.own[i](0, 0);
                const double off = state_.off[i] * state_.off[i] / std::max(left, 1e-3 / table_weight(i));
                if (view_used_[i] && off / angle_limit > worst) {
                    worst = off / angle_limit;
                    view = static_cast<std::ptrdiff_t>(i);
                }
            }
            for (std::size_t i = 0; i < sights_.size() && !as_poses_; ++i) {
                const double off = residual(state_, sights_[i]).cwiseAbs2().dot(sights_[i].weight);
                if (sights_[i].used && off / sight_limit > worst) {
                    worst = off / sight_limit;
                    view = -1;
                    sight = static_cast<std::ptrdiff_t>(i);
                }
            }
            if (view < 0 && sight < 0) {
                return;
            }
            if (view >= 0) {
                if (++angles > most) {
                    result_.notes.emplace_back(
                        "too many angles do not fit the noise stated: check the sense of the angles and their noise");
                    view_used_.assign(views_.size(), true);
                    fit();
                    return;
                }
                view_used_[static_cast<std::size_t>(view)] = false;
            } else {
                Sight& s = sights_[static_cast<std::size_t>(sight)];
                s.used = false;
                result_.markers.push_back(
                    {.view = views_[s.view].view, .line = views_[s.view].line, .id = ids_[s.marker]});
            }
            fit();
        }
    }

    TurntableFit finish() {
        result_.point = to_vec(state_.point);
        result_.direction = to_vec(state_.direction);
        result_.across = {to_vec(state_.across.col(0)), to_vec(state_.across.col(1))};
        result_.chi_squared = chi_squared_;
        result_.freedom = freedom();
        double scale = 1.0;
        result_.noise_ratio = ratio_;
        if (!options_.fit_noise) {
            result_.noise_ratio = std::sqrt(chi_squared_ / result_.freedom);
            if (chi_squared_ > chi_squared_limit(result_.freedom, 1e-3)) {
                scale = chi_squared_ / result_.freedom;
                result_.notes.push_back(
                    fmt::format("the data scatter {:.2f} times as much as the noise stated allows: the uncertainty is "
                                "raised by that",
                                result_.noise_ratio));
            }
        }
        for (int r = 0; r < 4; ++r) {
            for (int c = 0; c < 4; ++c) {
                result_.covariance.at[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] =
                    0.5 * scale * (spread_.common(r, c) + spread_.common(c, r));
            }
        }
        report();
        if (!(result_.turn_sigma() <= options_.most_turn)) {
            refuse("the data do not show the axis's direction; 1 sigma in deg",
                   fmt::format("{:.3g}", result_.turn_sigma() / kDegree), "turn the table further, or add markers");
        }
        if (!(result_.place_sigma() <= options_.most_place)) {
            refuse("the data do not show where the axis is; 1 sigma in mm",
                   fmt::format("{:.3g}", result_.place_sigma() * 1e3),
                   "turn the table further, or take markers further from the axis");
        }
        return std::move(result_);
    }

    void report() {
        std::vector<double> squares(views_.size(), 0.0);
        std::vector<double> count(views_.size(), 0.0);
        double radius = 0.0;
        for (const Sight& s : sights_) {
            if (s.used) {
                squares[s.view] += residual(state_, s).squaredNorm() / 3.0;
                count[s.view] += 1.0;
            }
        }
        double all = 0.0;
        double number = 0.0;
        for (std::size_t i = 0; i < views_.size(); ++i) {
            result_.views.push_back({views_[i].view, angle_[i], state_.off[i], view_used_[i],
                                     count[i] > 0.0 ? std::sqrt(squares[i] / count[i]) : 0.0});
            if (!view_used_[i]) {
                result_.notes.push_back(
                    fmt::format("view {}: the angle read, {:.4f} deg, does not fit; its markers say {:.4f}",
                                views_[i].view, angle_[i] / kDegree, (angle_[i] + state_.off[i]) / kDegree));
            }
            all += squares[i];
            number += count[i];
        }
        result_.rms = std::sqrt(all / number);
        for (const Eigen::Vector3d& at : state_.at) {
            radius += (state_.across.transpose() * (at - state_.point)).squaredNorm();
        }
        result_.radius = std::sqrt(radius / static_cast<double>(state_.at.size()));
    }

    std::filesystem::path file_;
    std::vector<MarkerView> views_;
    TurntableOptions options_;
    bool as_poses_;
    TurntableFit result_;
    std::vector<double> angle_;
    std::vector<int> ids_;
    std::vector<Sight> sights_;
    std::vector<bool> view_used_;
    State state_;
    double ratio_ = 1.0;
    double chi_squared_ = 0.0;
    System::Spread spread_;
};

double worst_of(const Covariance<4>& c, std::size_t at) {
    const double sum = c.at[at][at] + c.at[at + 1][at + 1];
    const double half = 0.5 * (c.at[at][at] - c.at[at + 1][at + 1]);
    return std::sqrt(0.5 * sum + std::hypot(half, c.at[at][at + 1]));
}

}  // namespace

double TurntableFit::turn_sigma() const noexcept { return worst_of(covariance, 2); }
double TurntableFit::place_sigma() const noexcept { return worst_of(covariance, 0); }

TurntableFit fit_turntable(const std::filesystem::path& file, std::vector<MarkerView> views,
                           const TurntableOptions& options) {
    return Turntable(file, std::move(views), options, false).run();
}

TurntableFit fit_turntable_poses(const std::filesystem::path& file, const std::vector<NamedPose>& poses,
                                 double turn_sigma, const TurntableOptions& options) {
    const double lever = std::sqrt(6.0) * options.sigma / (2.0 * turn_sigma);
    const double sigma = std::sqrt(6.0) * options.sigma;
    std::vector<MarkerView> views;
    for (const NamedPose& pose : poses) {
        MarkerView view{.line = pose.line, .view = pose.view, .time = {}, .turn = pose.turn, .markers = {}};
        const Motion motion{to_eigen(pose.rotation), to_eigen(pose.translation)};
        for (int i = 0; i < 6; ++i) {
            Eigen::Vector3d place = Eigen::Vector3d::Zero();
            place[i / 2] = i % 2 == 0 ? lever : -lever;
            view.markers.push_back({pose.line, i + 1, to_vec(motion * place), {sigma, sigma, sigma}});
        }
        views.push_back(std::move(view));
    }
    return Turntable(file, std::move(views), options, true).run();
}

}  // namespace sc::host
