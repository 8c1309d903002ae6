// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <ranges>
#include <set>

#include <fmt/format.h>

#include "host/calibration/hand_eye_fit.hpp"
#include "host/calibration/rigid_fit.hpp"
#include "host/formats/error.hpp"
#include "host/registration/chain_problem.hpp"
#include "host/registration/match.hpp"
#include "host/registration/view_graph.hpp"

namespace sc::host {
namespace {

constexpr std::size_t kLeastMarkers = 3;
constexpr std::size_t kLeastReads = 3;
constexpr double kLoose = 10.0;  ///< places in c from the start are less certain than a sighting
constexpr double kKnownLeast = 1e-7;
constexpr double kFreeAngle = 1e-30;  ///< weight of a reading that is wrong

Eigen::Vector3d weight_of(const SeenMarker& m, double sigma) {
    Eigen::Vector3d s = to_eigen(m.sigma);
    for (Eigen::Index i = 0; i < 3; ++i) {
        s[i] = s[i] > 0.0 ? s[i] : sigma;
    }
    return s.cwiseAbs2().cwiseInverse();
}

class Start {
public:
    Start(const ChainInput& input, const ChainOptions& options) : input_(input), options_(options) {}

    ChainProblem run() {
        check_input();
        number();
        graph_ = build_view_graph(input_.file, seen_, input_.still, input_.known,
                                  {.sigma = options_.sigma,
                                   .find_wrong = options_.find_wrong,
                                   .axis = input_.axis ? std::optional(StartAxis{to_eigen(input_.axis->point),
                                                                                 to_eigen(input_.axis->direction)})
                                                       : std::nullopt});
        add_stops();
        add_markers();
        add_sights();
        free_wrong_angles();
        name_wrong();
        note_lone();
        add_pointing();
        add_robot();
        return std::move(out_);
    }

private:
    [[noreturn]] void refuse(int line, std::string problem, std::string value, std::string action) const {
        refuse_chain(input_, line, std::move(problem), std::move(value), std::move(action));
    }

    void check_input() const {
        if (input_.views.size() < 2) {
            refuse(0, "too few views to register", std::to_string(input_.views.size()),
                   "give two or more, each with three markers in common with another");
        }
        for (const ChainView& view : input_.views) {
            if (view.seen.markers.size() < kLeastMarkers) {
                refuse(view.seen.line, "view has fewer than three markers",
                       fmt::format("{}: {}", view.seen.view, view.seen.markers.size()),
                       "see three or more of them, not on a line; four or five let a wrong one be found");
            }
        }
    }

    /// Swapped and wrong numbers by mutual distances: of what stands still, and of what turns, each a rigid body.
    void number() {
        for (const ChainView& view : input_.views) {
            seen_.push_back(view.seen);
        }
        if (!options_.find_wrong) {
            return;
        }
        std::vector<MarkerView> still = seen_;
        std::vector<MarkerView> turning = seen_;
        for (std::size_t i = 0; i < seen_.size(); ++i) {
            const auto is_still = [this](const SeenMarker& m) { return input_.still.contains(m.id); };
            std::erase_if(turning[i].markers, is_still);
            std::erase_if(still[i].markers, [&](const SeenMarker& m) { return !is_still(m); });
        }
        for (std::vector<MarkerView>* body : {&still, &turning}) {
            const auto found = check_markers(*body, options_.sigma);
            out_.findings.insert(out_.findings.end(), found.begin(), found.end());
        }
        for (std::size_t i = 0; i < seen_.size(); ++i) {
            seen_[i].markers = still[i].markers;
            seen_[i].markers.insert(seen_[i].markers.end(), turning[i].markers.begin(), turning[i].markers.end());
        }
    }

    void add_stops() {
        const double weight = 1.0 / (options_.table * options_.table);
        for (std::size_t i = 0; i < seen_.size(); ++i) {
            const double turn = seen_[i].turn.value_or(0.0);
            if (i == 0 || turn != seen_[i - 1].turn.value_or(0.0)) {
                out_.model.stops.push_back({turn, weight});
            }
            out_.stop_of.push_back(out_.model.stops.size() - 1);
        }
        out_.state.off.assign(out_.model.stops.size(), 0.0);
        out_.turn_wrong.assign(out_.model.stops.size(), false);
    }

    void add_markers() {
        ChainState& state = out_.state;
        if (graph_.axis) {
            state.direction = graph_.axis->direction;
            state.across = across_of(state.direction);
            state.point = graph_.axis->point;
        }
        out_.model.has_axis = graph_.axis.has_value() && !input_.axis;
        for (const auto& [id, place] : graph_.place) {
            index_[id] = out_.ids.size();
            out_.ids.push_back(id);
            out_.model.turning.push_back(graph_.axis && !input_.still.contains(id));
            state.at.push_back(place);
        }
        for (const SeenMarker& m : input_.known) {
            const double sigma = std::max(m.sigma.x, kKnownLeast);
            out_.model.known.push_back({index_.at(m.id), to_eigen(m.place), 1.0 / (sigma * sigma)});
        }
        state.pose = graph_.pose;
        out_.model.poses = state.pose.size();
    }

    void add_sights() {
        for (std::size_t i = 0; i < seen_.size(); ++i) {
            for (std::size_t k = 0; k < seen_[i].markers.size(); ++k) {
                const SeenMarker& m = seen_[i].markers[k];
                const auto at = index_.find(m.id);
                if (at == index_.end()) {
                    continue;  // all its sightings are wrong
                }
                out_.model.sights.push_back({i, out_.stop_of[i], at->second, to_eigen(m.place),
                                             weight_of(m, options_.sigma), !graph_.wrong.contains({i, k})});
                out_.origins.push_back({false, i, m.line});
            }
        }
    }

    /// A view of whose turning markers most stand elsewhere has its angle wrong, not its markers: it is left free.
    void free_wrong_angles() {
        for (std::size_t stop = 0; stop < out_.model.stops.size(); ++stop) {
            double cosine = 0.0;
            double sine = 0.0;
            std::size_t wrong = 0;
            std::size_t count = 0;
            for (const ChainSight& s : out_.model.sights) {
                if (s.stop != stop || !out_.model.turning[s.marker]) {
                    continue;
                }
                const ChainState& state = out_.state;
                const Eigen::Vector3d u = state.direction;
                const Eigen::Vector3d now = state.pose[s.pose] * s.place - state.point;
                const Eigen::Vector3d zero = state.at[s.marker] - state.point;
                cosine += now.dot(zero) - now.dot(u) * zero.dot(u);
                sine += u.dot(zero.cross(now));
                wrong += s.used ? 0 : 1;
                ++count;
            }
            const bool named = std::ranges::any_of(std::views::iota(std::size_t{0}, seen_.size()), [&](std::size_t i) {
                return out_.stop_of[i] == stop && graph_.wrong_turn.contains(seen_[i].view);
            });
            if (count == 0 || (!named && (count < kLeastMarkers || 2 * wrong <= count))) {
                continue;
            }
            ChainStop& it = out_.model.stops[stop];
            out_.state.off[stop] = std::remainder(std::atan2(sine, cosine) - it.turn, 2.0 * std::acos(-1.0));
            it.weight = kFreeAngle;
            out_.turn_wrong[stop] = true;
            for (ChainSight& s : out_.model.sights) {
                s.used = s.used || (s.stop == stop && out_.model.turning[s.marker]);
            }
        }
    }

    void name_wrong() {
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < out_.model.sights.size(); ++i) {
            if (!out_.model.sights[i].used) {
                const SightOrigin& from = out_.origins[i];
                out_.findings.push_back({.kind = MarkerFinding::Kind::wrong,
                                         .view = seen_[from.view].view,
                                         .line = from.line,
                                         .id = out_.ids[out_.model.sights[i].marker]});
                ++wrong;
            }
        }
        if (5 * wrong > 2 * out_.model.sights.size()) {
            refuse(0, "too many markers do not match between views",
                   fmt::format("{} of {}", wrong, out_.model.sights.size()),
                   "check the numbers of the markers, and which of them stand still");
        }
    }

    void note_lone() {
        std::vector<int> views(out_.ids.size(), 0);
        for (const ChainSight& s : out_.model.sights) {
            ++views[s.marker];
        }
        const auto lone = std::ranges::count(views, 1);
        if (lone > 0) {
            const auto first = static_cast<std::size_t>(std::ranges::find(views, 1) - views.begin());
            out_.notes.push_back(
                lone == 1
                    ? fmt::format("marker {} is seen by one view alone: if wrong, nobody could tell", out_.ids[first])
                    : fmt::format("{} markers ({}, ...) are seen by one view each: if one is wrong, nobody could tell",
                                  lone, out_.ids[first]));
        }
    }

    void add_pointing() {
        if (input_.pointing.empty()) {
            return;
        }
        std::vector<SeenMarker> in_h;
        std::vector<SeenMarker> in_c;
        for (const MarkerView& view : input_.pointing) {
            for (const SeenMarker& m : view.markers) {
                const auto at = index_.find(m.id);
                if (at == index_.end()) {
                    out_.notes.push_back(fmt::format("marker {} was pointed at, but no view shows it", m.id));
                    continue;
                }
                if (out_.model.turning[at->second] && !view.turn) {
                    refuse_pointing(m.line, "place was pointed at on the table, whose angle is not given",
                                    std::to_string(m.id), "give a column turn_deg");
                }
                const auto pair = static_cast<int>(in_h.size());  // a marker may be pointed at twice
                const double loose = kLoose * options_.sigma;
                in_h.push_back(m);
                in_h.back().id = pair;
                in_c.push_back({m.line,
                                pair,
                                to_vec(chain_place(out_.state, out_.model.turning[at->second],
                                                   out_.state.at[at->second], view.turn.value_or(0.0))),
                                {loose, loose, loose}});
            }
        }
        if (in_h.size() < kLeastMarkers) {
            refuse_pointing(0, "fewer than three markers that a view shows were pointed at",
                            std::to_string(in_h.size()), "point at three or more, not on a line");
        }
        const RigidFit fit = fit_pointing(in_h, in_c);
        out_.h_pose = out_.model.poses++;
        out_.state.pose.push_back(Motion{to_eigen(fit.rotation), to_eigen(fit.translation)}.inverse());
        add_pointed_sights(fit);
    }

    [[noreturn]] void refuse_pointing(int line, std::string problem, std::string value, std::string action) const {
        throw InputError({.file = input_.pointing_file.string(),
                          .line = line,
                          .problem = std::move(problem),
                          .value = std::move(value),
                          .action = std::move(action)});
    }

    [[nodiscard]] RigidFit fit_pointing(const std::vector<SeenMarker>& in_h,
                                        const std::vector<SeenMarker>& in_c) const {
        RigidOptions options;
        options.sigma = options_.pointing;
        options.find_wrong = options_.find_wrong;
        options.most_turn = 10.0 * options_.most_turn;
        options.most_place = 10.0 * options_.most_place;
        try {
            return fit_rigid(input_.pointing_file, in_h, in_c, options);
        } catch (const InputError& error) {
            const std::string reason = misfit_reason(in_h, in_c);
            if (reason.empty()) {
                throw;
            }
            refuse_pointing(0, "places pointed at and markers seen: " + reason, {},
                            "give both in their unit and in right-handed frames");
        }
    }

    void add_pointed_sights(const RigidFit& fit) {
        int pair = 0;
        for (std::size_t v = 0; v < input_.pointing.size(); ++v) {
            const MarkerView& view = input_.pointing[v];
            out_.model.stops.push_back({view.turn.value_or(0.0), 1.0 / (options_.table * options_.table)});
            out_.state.off.push_back(0.0);
            out_.turn_wrong.push_back(false);
            for (const SeenMarker& m : view.markers) {
                const auto at = index_.find(m.id);
                if (at == index_.end()) {
                    continue;
                }
                const auto found = std::ranges::find(fit.markers, pair++, &RigidMarker::id);
                const bool used = found == fit.markers.end() || found->used;
                out_.model.sights.push_back({*out_.h_pose, out_.model.stops.size() - 1, at->second, to_eigen(m.place),
                                             weight_of(m, options_.pointing), used});
                out_.origins.push_back({true, v, m.line});
                if (!used) {
                    out_.findings.push_back({.kind = MarkerFinding::Kind::wrong,
                                             .view = "pointing " + view.view,
                                             .line = m.line,
                                             .id = m.id});
                }
            }
        }
    }

    void add_robot() {
        if (options_.robot == RobotUse::left_out) {
            return;
        }
        std::vector<Motion> f;
        std::vector<Motion> c;
        std::vector<ChainRead> reads;
        for (std::size_t i = 0; i < input_.views.size(); ++i) {
            if (const auto& pose = input_.views[i].b_from_f) {
                f.push_back({to_eigen(pose->rotation), to_eigen(pose->translation)});
                c.push_back(out_.state.pose[i].inverse());
                reads.push_back({i, f.back()});
            }
        }
        if (reads.size() < kLeastReads) {
            return;
        }
        out_.state.f_from_s = start_hand_eye(f, c).x;
        std::vector<PlacePair> pairs;  // places and axes of all flanges, in c and in b
        for (const ChainRead& read : reads) {
            const Motion flange = out_.state.pose[read.pose] * out_.state.f_from_s.inverse();
            pairs.push_back({flange.t, read.b_from_f.t, 1.0});
            for (Eigen::Index k = 0; k < 3; ++k) {
                const Eigen::Vector3d arm = 0.3 * Eigen::Matrix3d::Identity().col(k);
                pairs.push_back({flange * arm, read.b_from_f * arm, 1.0});
            }
        }
        out_.state.c_from_b = fit_motion(pairs);
        out_.model.reads = std::move(reads);
        out_.model.robot_turn = options_.robot_turn;
        out_.model.robot_place = options_.robot_place;
    }

    const ChainInput& input_;
    const ChainOptions& options_;
    std::vector<MarkerView> seen_;
    ViewGraph graph_;
    std::map<int, std::size_t> index_;
    ChainProblem out_;
};

}  // namespace

void refuse_chain(const ChainInput& input, int line, std::string problem, std::string value, std::string action) {
    throw InputError({.file = input.file.string(),
                      .line = line,
                      .problem = std::move(problem),
                      .value = std::move(value),
                      .action = std::move(action)});
}

ChainProblem start_chain(const ChainInput& input, const ChainOptions& options) { return Start(input, options).run(); }

}  // namespace sc::host
