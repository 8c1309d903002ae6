// SPDX-License-Identifier: Apache-2.0
#include "host/registration/view_graph.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "host/calibration/rigid_fit.hpp"
#include "host/calibration/turntable_fit.hpp"
#include "host/formats/error.hpp"
#include "host/registration/match.hpp"

namespace sc::host {
namespace {

constexpr double kSameTurn = 1e-9;  ///< radians
constexpr double kLoose = 10.0;     ///< what views before have gathered is less certain than one sighting
constexpr double kFarOff = 5e-4;    ///< metres: wrong for certain; the joint fit looks closer
constexpr double kFarOffSigmas = 60.0;
constexpr double kLeastArc = std::numbers::pi / 180.0;
constexpr std::size_t kLeast = 3;

struct Sum {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double count = 0.0;
    void add(const Eigen::Vector3d& p) {
        sum += p;
        count += 1.0;
    }
    [[nodiscard]] Eigen::Vector3d mean() const { return sum / count; }
};

class Graph {
public:
    Graph(const std::filesystem::path& file, const std::vector<MarkerView>& views, const std::set<int>& still,
          const ViewGraphOptions& options)
        : file_(file), views_(views), still_(still), options_(options), pose_(views.size()) {
        out_.axis = options.axis;
        for (const MarkerView& view : views_) {
            const double turn = view.turn.value_or(0.0);
            const auto same = std::ranges::find_if(turns_, [&](double t) { return std::abs(t - turn) < kSameTurn; });
            stop_.push_back(static_cast<std::size_t>(same - turns_.begin()));
            if (same == turns_.end()) {
                turns_.push_back(turn);
            }
        }
    }

    ViewGraph run(const std::vector<SeenMarker>& known) {
        if (known.empty()) {
            take(0, Motion{});
        }
        for (const SeenMarker& m : known) {
            still_map_[m.id].add(to_eigen(m.place));
            known_.insert(m.id);
        }
        for (;;) {
            const std::optional<std::size_t> next = next_view();
            if (!next) {
                break;
            }
            if (common_with_map(*next).size() >= kLeast) {
                register_view(*next);
                continue;
            }
            if (!out_.axis && find_axis()) {
                continue;
            }
            refuse_view(*next);
        }
        if (!out_.axis && turns_.size() > 1 && has_turning()) {
            if (!find_axis()) {
                refuse_axis();
            }
        }
        if (options_.find_wrong) {
            vote();
        }
        gather();
        for (const auto& pose : pose_) {
            out_.pose.push_back(*pose);
        }
        return out_;
    }

private:
    [[noreturn]] void refuse(int line, std::string problem, std::string value, std::string action) const {
        throw InputError({.file = file_.string(),
                          .line = line,
                          .problem = std::move(problem),
                          .value = std::move(value),
                          .action = std::move(action)});
    }
    [[noreturn]] void refuse_bad(std::size_t view, std::string problem, std::string value, std::string action) const {
        throw BadView({.file = file_.string(),
                       .line = views_[view].line,
                       .problem = std::move(problem),
                       .value = std::move(value),
                       .action = std::move(action)},
                      view);
    }
    [[nodiscard]] bool is_still(int id) const { return still_.contains(id); }
    [[nodiscard]] bool has_turning() const {
        return std::ranges::any_of(views_, [this](const MarkerView& v) {
            return std::ranges::any_of(v.markers, [this](const SeenMarker& m) { return !is_still(m.id); });
        });
    }
    [[nodiscard]] Eigen::Vector3d turned(const Eigen::Vector3d& p, double by) const {
        return out_.axis->point + exp_turn(by * out_.axis->direction) * (p - out_.axis->point);
    }

    /// Where the map says that a marker stands in c as the view saw it.
    [[nodiscard]] std::optional<Eigen::Vector3d> in_map(std::size_t view, int id) const {
        if (is_still(id)) {
            const auto at = still_map_.find(id);
            return at == still_map_.end() ? std::nullopt : std::optional(at->second.mean());
        }
        if (const auto at = turning_map_.find({id, stop_[view]}); at != turning_map_.end()) {
            return at->second.mean();
        }
        if (out_.axis) {
            for (std::size_t s = 0; s < turns_.size(); ++s) {
                if (const auto at = turning_map_.find({id, s}); at != turning_map_.end()) {
                    return turned(at->second.mean(), turns_[stop_[view]] - turns_[s]);
                }
            }
        }
        return std::nullopt;
    }
    [[nodiscard]] std::vector<SeenMarker> common_with_map(std::size_t view) const {
        std::vector<SeenMarker> out;
        for (const SeenMarker& m : views_[view].markers) {
            if (const auto place = in_map(view, m.id)) {
                const double sigma = m.sigma.x > 0.0 ? m.sigma.x : options_.sigma;
                out.push_back({m.line, m.id, to_vec(*place), {kLoose * sigma, kLoose * sigma, kLoose * sigma}});
            }
        }
        return out;
    }
    [[nodiscard]] std::optional<std::size_t> next_view() const {
        std::optional<std::size_t> best;
        std::size_t most = 0;
        for (std::size_t i = 0; i < views_.size(); ++i) {
            const std::size_t common = pose_[i] ? 0 : common_with_map(i).size();
            if (!pose_[i] && (!best || common > most)) {
                best = i;
                most = common;
            }
        }
        return best;
    }

    void register_view(std::size_t view) {
        const std::vector<SeenMarker> map = common_with_map(view);
        RigidOptions options;
        options.sigma = options_.sigma;
        options.find_wrong = options_.find_wrong;
        options.most_turn = 0.2;
        options.most_place = 0.05;
        RigidFit fit;
        try {
            fit = fit_rigid(file_, map, views_[view].markers, options);
        } catch (const InputError& error) {
            refuse_misfit(view, map);
            refuse_bad(view, "view cannot be registered: " + error.problem(),
                       views_[view].view + (error.value().empty() ? "" : ": " + error.value()), error.action());
        }
        const auto used = static_cast<std::size_t>(std::ranges::count(fit.markers, true, &RigidMarker::used));
        if (2 * used < fit.markers.size()) {
            refuse_misfit(view, map);
            refuse_bad(view, "most markers of the view do not match those registered before it",
                       fmt::format("{}: {} of {} do", views_[view].view, used, fit.markers.size()),
                       "check the numbers of its markers, and which of them stand still");
        }
        for (const RigidMarker& m : fit.markers) {
            if (!m.used) {
                off_.insert({view, m.id});
            }
        }
        take(view, {to_eigen(fit.rotation), to_eigen(fit.translation)});
    }

    /// If there is a reason that explains all of it.
    void refuse_misfit(std::size_t view, const std::vector<SeenMarker>& map) const {
        const std::string reason = misfit_reason(map, views_[view].markers);
        if (!reason.empty()) {
            refuse(views_[view].line, "view and the views before it: " + reason, views_[view].view,
                   "give all markers in one unit and in right-handed frames");
        }
    }

    void take(std::size_t view, const Motion& pose) {
        pose_[view] = pose;
        for (const SeenMarker& m : views_[view].markers) {
            if (off_.contains({view, m.id})) {
                continue;
            }
            const Eigen::Vector3d p = pose * to_eigen(m.place);
            if (!is_still(m.id)) {
                turning_map_[{m.id, stop_[view]}].add(p);
            } else if (!known_.contains(m.id)) {
                still_map_[m.id].add(p);
            }
        }
    }

    [[nodiscard]] bool find_axis() {
        std::map<int, std::set<std::size_t>> stops;
        for (std::size_t i = 0; i < views_.size(); ++i) {
            for (const SeenMarker& m : views_[i].markers) {
                if (pose_[i] && !is_still(m.id) && !off_.contains({i, m.id})) {
                    stops[m.id].insert(stop_[i]);
                }
            }
        }
        std::vector<MarkerView> turning;
        std::set<std::size_t> seen;
        for (std::size_t i = 0; i < views_.size(); ++i) {
            if (!pose_[i]) {
                continue;
            }
            MarkerView view = views_[i];
            view.turn = turns_[stop_[i]];
            std::erase_if(view.markers, [&](const SeenMarker& m) {
                return is_still(m.id) || off_.contains({i, m.id}) || stops[m.id].size() < 2;
            });
            for (SeenMarker& m : view.markers) {
                m.place = to_vec(*pose_[i] * to_eigen(m.place));
                m.sigma = {};
            }
            if (!view.markers.empty()) {
                seen.insert(stop_[i]);
                turning.push_back(std::move(view));
            }
        }
        const auto [least, most] = std::ranges::minmax(turns_);
        if (seen.size() < 2 || turning.size() < 3 || most - least < kLeastArc) {
            return false;
        }
        TurntableOptions options;
        options.sigma = 5.0 * options_.sigma;
        options.find_wrong = options_.find_wrong;
        options.most_turn = 0.1;
        options.most_place = 0.05;
        const TurntableFit fit = fit_turntable(file_, turning, options);
        out_.axis = StartAxis{to_eigen(fit.point), to_eigen(fit.direction)};
        for (const TurntableView& view : fit.views) {
            if (!view.used) {
                out_.wrong_turn.insert(view.name);
            }
        }
        return true;
    }

    [[noreturn]] void refuse_view(std::size_t view) const {
        std::string left;
        for (std::size_t i = 0; i < views_.size(); ++i) {
            left += pose_[i] || i == view ? "" : ", " + views_[i].view;
        }
        refuse_bad(
            view,
            fmt::format("view has {} markers in common with those registered before it, three are needed and four or "
                        "five are sound",
                        common_with_map(view).size()),
            views_[view].view + (left.empty() ? "" : " (not reached either: " + left.substr(2) + ")"),
            "add reference markers that stand still, or views between; markers on the table join views at one angle "
            "alone, until some are seen at three");
    }
    [[noreturn]] void refuse_axis() const {
        const auto [least, most] = std::ranges::minmax(turns_);
        refuse(
            0,
            "markers turn with the table, but no three views show the same ones at other angles: the axis is not seen",
            fmt::format("{} angles over {:.3f} deg", turns_.size(), (most - least) * 180.0 / std::numbers::pi),
            "view some markers on the table at three angles or more over 60 deg, or give a calibration with the axis");
    }

    /// All sightings of a marker in c, table at C = 0.
    [[nodiscard]] std::map<int, std::vector<std::pair<SightName, Eigen::Vector3d>>> sightings() const {
        std::map<int, std::vector<std::pair<SightName, Eigen::Vector3d>>> out;
        for (std::size_t i = 0; i < views_.size(); ++i) {
            for (std::size_t k = 0; k < views_[i].markers.size(); ++k) {
                const SeenMarker& m = views_[i].markers[k];
                const Eigen::Vector3d p = *pose_[i] * to_eigen(m.place);
                const bool turns = !is_still(m.id) && out_.axis;
                out[m.id].push_back({{i, k}, turns ? turned(p, -turns_[stop_[i]]) : p});
            }
        }
        return out;
    }
    /// The sighting with which most others agree tells which are wrong, whichever came first.
    void vote() {
        const double limit = std::max(kFarOff, kFarOffSigmas * options_.sigma);
        for (const auto& [id, all] : sightings()) {
            std::size_t best = 0;
            std::size_t most = 0;
            for (std::size_t i = 0; i < all.size(); ++i) {
                const auto agree = static_cast<std::size_t>(std::ranges::count_if(
                    all, [&](const auto& other) { return (other.second - all[i].second).norm() < limit; }));
                if (agree > most) {
                    most = agree;
                    best = i;
                }
            }
            for (const auto& [name, place] : all) {
                const bool far = (place - all[best].second).norm() >= limit;
                if (far || (all.size() == 1 && off_.contains({name.view, id}))) {
                    out_.wrong.insert(name);
                }
            }
        }
    }
    void gather() {
        std::map<int, Sum> sums;
        for (const auto& [id, all] : sightings()) {
            for (const auto& [name, place] : all) {
                if (!out_.wrong.contains(name)) {
                    sums[id].add(place);
                }
            }
        }
        for (const auto& [id, sum] : sums) {
            out_.place[id] = sum.mean();
        }
        for (const int id : known_) {
            out_.place[id] = still_map_.at(id).mean();
        }
    }

    std::filesystem::path file_;
    const std::vector<MarkerView>& views_;
    const std::set<int>& still_;
    ViewGraphOptions options_;
    std::vector<std::optional<Motion>> pose_;
    std::vector<double> turns_;      ///< angles at which the table stood
    std::vector<std::size_t> stop_;  ///< of each view, in turns_
    std::map<int, Sum> still_map_;
    std::map<std::pair<int, std::size_t>, Sum> turning_map_;  ///< by id and stop
    std::set<int> known_;
    std::set<std::pair<std::size_t, int>> off_;  ///< view, id
    ViewGraph out_;
};

}  // namespace

ViewGraph build_view_graph(const std::filesystem::path& file, const std::vector<MarkerView>& views,
                           const std::set<int>& still, const std::vector<SeenMarker>& known,
                           const ViewGraphOptions& options) {
    return Graph(file, views, still, options).run(known);
}

}  // namespace sc::host
