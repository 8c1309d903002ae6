// SPDX-License-Identifier: Apache-2.0
#include "host/registration/chain.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "host/registration/chain_problem.hpp"
#include "host/registration/view_graph.hpp"

namespace sc::host {
namespace {

constexpr double kFalseAlarm = 1e-4;
constexpr int kRobotRounds = 6;
constexpr double kRobotStill = 0.05;  ///< the noise changed by less: it is found
constexpr std::size_t kMostRounds = 200;
constexpr std::size_t kBadShare = 5;  ///< one of so many views may be left out
constexpr double kFreeAngle = 1e-30;  ///< weight of a reading that is wrong

class Bundle {
public:
    Bundle(const ChainInput& input, const ChainOptions& options)
        : input_(input), options_(options), problem_(start_chain(input, options)) {}

    ChainResult run() {
        fit();
        for (std::size_t round = 0; options_.find_wrong && round < kMostRounds && drop_worst(); ++round) {
            refuse_many();
            fit();
        }
        note_turns();
        return chain_result(input_, options_, problem_, &*spread_);
    }

private:
    void fit() {
        ChainModel& model = problem_.model;
        if (options_.robot == RobotUse::weighed && !model.reads.empty() && problem_.robot_ratio == 0.0) {
            problem_.robot_ratio = std::max(1.0, start_ratio());
        }
        for (int round = 0;; ++round) {
            model.robot_turn = options_.robot_turn * std::max(problem_.robot_ratio, 1.0);
            model.robot_place = options_.robot_place * std::max(problem_.robot_ratio, 1.0);
            problem_.chi_squared = fit_chain_state(model, problem_.state);
            spread_ = chain_spread(model, problem_.state);
            if (model.reads.empty()) {
                return;
            }
            const double found = std::max(problem_.robot_ratio, 1.0) * robot_ratio(model, problem_.state, *spread_);
            if (options_.robot == RobotUse::trusted) {
                problem_.robot_ratio = found;
                model.robot_turn = options_.robot_turn;
                model.robot_place = options_.robot_place;
                return;
            }
            const double next = std::max(found, 1.0);
            const bool still = std::abs(next - problem_.robot_ratio) < kRobotStill * problem_.robot_ratio;
            if (still || round == kRobotRounds) {
                return;
            }
            problem_.robot_ratio = next;
        }
    }

    /// From the closed form: how far robot and markers are apart, so that the fit does not begin with a tug of war.
    [[nodiscard]] double start_ratio() const {
        double sum = 0.0;
        for (const ChainRead& read : problem_.model.reads) {
            const auto r = read_residual(problem_.state, read);
            sum += r.head<3>().squaredNorm() / std::pow(options_.robot_turn, 2) +
                   r.tail<3>().squaredNorm() / std::pow(options_.robot_place, 2);
        }
        return std::sqrt(sum / (6.0 * static_cast<double>(problem_.model.reads.size())));
    }

    /// Chi-squared of a sight with what the fit took of it given back.
    [[nodiscard]] double surprise(const ChainSight& s) const {
        const ChainModel& model = problem_.model;
        const Eigen::Vector3d residual = chain_residual(model, problem_.state, s);
        if (residual.cwiseAbs2().dot(s.weight) < 6.0) {
            return 0.0;  // far from any limit even if the fit took most of it
        }
        const double turn = model.stops[s.stop].turn + problem_.state.off[s.stop];
        const ChainSlope slope = chain_slope(model, problem_.state, s.pose, s.marker, turn, s.stop);
        const Eigen::Matrix3d noise = s.weight.cwiseInverse().asDiagonal();
        const Eigen::Matrix3d of_fit = spread_->of(s.marker, slope.parts, slope.own);
        const Eigen::Matrix3d left = noise - of_fit + 0.02 * noise;
        const Eigen::LDLT<Eigen::Matrix3d> solver(left);
        return solver.isPositive() ? residual.dot(solver.solve(residual)) : 0.0;
    }

    /// Leaves out the worst of each view and each marker, or frees an angle; false if all is sound.
    bool drop_worst() {
        ChainModel& model = problem_.model;
        if (free_worst_angle()) {
            return true;
        }
        const double limit = chi_squared_limit(3.0, kFalseAlarm / static_cast<double>(model.sights.size()));
        struct Suspect {
            double surprise = 0.0;
            std::size_t sight = 0;
        };
        std::vector<Suspect> suspects;
        for (std::size_t i = 0; i < model.sights.size(); ++i) {
            const double s = model.sights[i].used ? surprise(model.sights[i]) : 0.0;
            if (s > limit) {
                suspects.push_back({s, i});
            }
        }
        std::ranges::sort(suspects, std::greater{}, &Suspect::surprise);
        std::set<std::size_t> poses;
        std::set<std::size_t> markers;
        for (const Suspect& suspect : suspects) {
            ChainSight& s = model.sights[suspect.sight];
            // What the worst pulls along with it looks bad too: of that, the next round tells.
            if (poses.contains(s.pose) || markers.contains(s.marker) || suspect.surprise < 0.3 * suspects[0].surprise) {
                continue;
            }
            poses.insert(s.pose);
            markers.insert(s.marker);
            s.used = false;
            const SightOrigin& from = problem_.origins[suspect.sight];
            problem_.findings.push_back({.kind = MarkerFinding::Kind::wrong,
                                         .view = from.pointed ? "pointing " + input_.pointing[from.view].view
                                                              : input_.views[from.view].seen.view,
                                         .line = from.line,
                                         .id = problem_.ids[s.marker]});
        }
        return !suspects.empty();
    }

    bool free_worst_angle() {
        ChainModel& model = problem_.model;
        double most = chi_squared_limit(2.0, kFalseAlarm / static_cast<double>(model.stops.size()));
        std::size_t worst = model.stops.size();
        for (std::size_t i = 0; i < model.stops.size(); ++i) {
            const double weight = model.stops[i].weight;
            if (problem_.turn_wrong[i]) {
                continue;
            }
            const double variance = spread_->common()(model.stop_at(i), model.stop_at(i));
            const double left = std::max(1.0 / weight - variance, 0.02 / weight);
            const double s = problem_.state.off[i] * problem_.state.off[i] / left;
            if (s > most) {
                most = s;
                worst = i;
            }
        }
        if (worst == model.stops.size()) {
            return false;
        }
        model.stops[worst].weight = kFreeAngle;
        problem_.turn_wrong[worst] = true;
        return true;
    }

    void refuse_many() const {
        const auto wrong =
            static_cast<std::size_t>(std::ranges::count(problem_.model.sights, false, &ChainSight::used));
        if (4 * wrong > problem_.model.sights.size()) {
            refuse_chain(input_, 0, "too many markers do not fit between views",
                         fmt::format("{} of {}", wrong, problem_.model.sights.size()),
                         "state the noise as it is (sigma_um), and check which markers stand still");
        }
    }

    void note_turns() {
        for (std::size_t i = 0; i < input_.views.size(); ++i) {
            const std::size_t stop = problem_.stop_of[i];
            if (problem_.turn_wrong[stop]) {
                problem_.notes.push_back(
                    fmt::format("view {}: the table's angle was read wrong, by {:.4f} deg; it does not count",
                                input_.views[i].seen.view, -problem_.state.off[stop] * 180.0 / std::acos(-1.0)));
            }
        }
    }

    const ChainInput& input_;
    const ChainOptions& options_;
    ChainProblem problem_;
    std::optional<ChainSystem::Spread> spread_;
};

}  // namespace

const ChainMarkerResult* ChainResult::find(int id) const noexcept {
    const auto at = std::ranges::find(markers, id, &ChainMarkerResult::id);
    return at == markers.end() ? nullptr : &*at;
}

ChainResult fit_chain(const ChainInput& input, const ChainOptions& options) {
    ChainInput left = input;
    std::vector<std::string> bad;
    std::vector<std::string> why;
    for (;;) {
        try {
            ChainResult out = Bundle(left, options).run();
            out.bad_views = bad;
            out.notes.insert(out.notes.begin(), why.begin(), why.end());
            return out;
        } catch (const BadView& error) {
            if (!options.find_wrong || kBadShare * (bad.size() + 1) > input.views.size()) {
                throw;
            }
            bad.push_back(left.views[error.view()].seen.view);
            why.push_back(fmt::format("view {} is left out: {}", bad.back(), error.problem()));
            left.views.erase(left.views.begin() + static_cast<std::ptrdiff_t>(error.view()));
        }
    }
}

ChainResult chain_step_by_step(const ChainInput& input, const ChainOptions& options) {
    return chain_result(input, options, start_chain(input, options), nullptr);
}

}  // namespace sc::host
