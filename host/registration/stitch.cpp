// SPDX-License-Identifier: Apache-2.0
#include "host/registration/stitch.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <ranges>

#include <fmt/format.h>

#include "host/calibration/motion.hpp"
#include "host/formats/error.hpp"
#include "host/registration/match.hpp"

namespace sc::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kFirstUnknown = 900'001;
constexpr double kFarthest = 100.0;  ///< metres

[[noreturn]] void refuse(const ScanSet& set, int line, std::string problem, std::string value, std::string action) {
    throw InputError({.file = set.file.string(),
                      .line = line,
                      .problem = std::move(problem),
                      .value = std::move(value),
                      .action = std::move(action)});
}

std::vector<SeenMarker> cloud_of(const Target& target) {
    std::vector<SeenMarker> out;
    for (const TargetMarker& m : target.markers) {
        out.push_back({0, m.id, m.place, {m.sigma, m.sigma, m.sigma}});
    }
    return out;
}

/// Numbers for markers whose own mean nothing.
class Numberer {
public:
    Numberer(const ScanSet& set, const ScanTargets& targets) : set_(set), tolerance_(targets.tolerance) {
        for (const Target& t : targets.targets) {
            bodies_.push_back(cloud_of(t));
        }
    }

    void run(std::vector<ChainView>& views) {
        for (ChainView& view : views) {
            std::vector<bool> named(view.seen.markers.size(), false);
            const std::vector<SeenMarker> before = view.seen.markers;
            std::string why;
            for (const auto& body : bodies_) {
                name_by(body, before, view, named, why);
            }
            for (const auto& [turn, body] : gathered_) {
                if (std::abs(turn - view.seen.turn.value_or(0.0)) < 1e-9) {
                    name_by(body, before, view, named, why);
                }
            }
            const bool first = bodies_.empty() && gathered_.empty();
            if (!first && std::ranges::count(named, true) == 0) {
                refuse(set_, view.seen.line, "markers without numbers match nothing by their distances: " + why,
                       view.seen.view, "see five or more markers of a target or of another view at the same angle");
            }
            for (std::size_t k = 0; k < named.size(); ++k) {
                if (!named[k]) {
                    view.seen.markers[k].id = next_++;
                }
            }
            gathered_.emplace_back(view.seen.turn.value_or(0.0), view.seen.markers);
        }
    }

private:
    void name_by(const std::vector<SeenMarker>& body, const std::vector<SeenMarker>& before, ChainView& view,
                 std::vector<bool>& named, std::string& why) const {
        std::vector<SeenMarker> left;
        std::vector<std::size_t> index;
        for (std::size_t k = 0; k < before.size(); ++k) {
            if (!named[k]) {
                left.push_back(before[k]);
                index.push_back(k);
            }
        }
        const auto matches = match_by_distances(body, left, tolerance_);
        if (!matches) {
            why = matches.error();
            return;
        }
        for (const MarkerMatch& m : *matches) {
            const int id = body[m.a].id;
            const bool taken = std::ranges::any_of(std::views::iota(std::size_t{0}, named.size()), [&](std::size_t k) {
                return named[k] && view.seen.markers[k].id == id;
            });
            if (!taken) {
                view.seen.markers[index[m.b]].id = id;
                named[index[m.b]] = true;
            }
        }
    }

    const ScanSet& set_;
    double tolerance_;
    std::vector<std::vector<SeenMarker>> bodies_;
    std::vector<std::pair<double, std::vector<SeenMarker>>> gathered_;  ///< views numbered before, by angle
    int next_ = kFirstUnknown;
};

}  // namespace

ChainInput chain_input(const ScanSet& set, const ScanTargets& targets) {
    ChainInput out;
    out.file = set.file;
    std::map<int, std::string> owner;
    std::string measured;
    for (const Target& target : targets.targets) {
        for (const TargetMarker& m : target.markers) {
            const auto [at, added] = owner.try_emplace(m.id, target.id);
            if (!added) {
                refuse(set, 0, "two targets have a marker of the same id (" + at->second + ", " + target.id + ")",
                       std::to_string(m.id), "number the markers of all targets differently");
            }
            out.still.insert(m.id);
            if (target.kind == TargetKind::fixed && m.sigma > 0.0) {
                if (!measured.empty() && measured != target.id) {
                    refuse(set, 0, "two fixed targets have measured places: c can be the frame of one",
                           measured + ", " + target.id, "write sigma_um = 0 in one of them");
                }
                measured = target.id;
                out.known.push_back({0, m.id, m.place, {m.sigma, m.sigma, m.sigma}});
            }
        }
    }
    out.still.insert(targets.still.begin(), targets.still.end());
    for (const ScanView& view : set.views) {
        if (view.markers.empty()) {
            refuse(set, view.line, "view has a cloud but no markers", view.id,
                   "give its markers: clouds are brought together by them");
        }
        ChainView next;
        next.seen.line = view.line;
        next.seen.view = view.id;
        next.seen.turn = view.c_deg * kDegree;
        next.b_from_f = view.b_from_f;
        for (const ScanMarker& m : view.markers) {
            next.seen.markers.push_back({view.line, m.id, m.place, {m.sigma, m.sigma, m.sigma}});
        }
        out.views.push_back(std::move(next));
    }
    if (targets.ids_unknown) {
        Numberer(set, targets).run(out.views);
        const bool one_angle =
            std::ranges::all_of(set.views, [&](const ScanView& v) { return v.c_deg == set.views.front().c_deg; });
        for (const ChainView& view : out.views) {
            for (const SeenMarker& m : view.seen.markers) {
                if (one_angle) {
                    out.still.insert(m.id);
                }
            }
        }
    }
    return out;
}

PointCloud stitch_clouds(const ScanSet& set, const ChainResult& chain, const LengthUnit& unit) {
    PointCloud out;
    for (std::size_t i = 0; i < set.views.size(); ++i) {
        const ScanView& view = set.views[i];
        if (view.cloud.empty()) {
            continue;
        }
        const auto found = std::ranges::find(chain.views, view.id, &ChainViewResult::name);
        if (found == chain.views.end()) {
            refuse(set, view.line, "view has a cloud but no pose", view.id, "register it");
        }
        const double turn = found->turn + found->turn_off;
        if (!chain.axis && std::abs(turn) > 1e-9) {
            refuse(set, view.line, "cloud was taken with the table turned, but its axis is not known", view.id,
                   "see markers on the table at three angles or more, or give a calibration with the axis");
        }
        const Motion pose{to_eigen(found->rotation), to_eigen(found->translation)};
        const Eigen::Vector3d u = chain.axis ? to_eigen(chain.axis->direction) : Eigen::Vector3d::UnitZ();
        const Eigen::Vector3d point = chain.axis ? to_eigen(chain.axis->point) : Eigen::Vector3d::Zero();
        const Eigen::Matrix3d back = exp_turn(-turn * u);
        const Motion to_zero{back, point - back * point};
        const Motion all = to_zero * pose;
        for (const Vec3& p : read_scan(view.cloud, unit).cloud.points) {
            if (norm(p) > kFarthest) {
                throw InputError({.file = view.cloud.string(),
                                  .problem = "a point lies further than 100 m away",
                                  .value = fmt::format("{:.6g} m", norm(p)),
                                  .action = "state the cloud's unit"});
            }
            out.points.push_back(to_vec(all * to_eigen(p)));
            out.view.push_back(static_cast<std::uint32_t>(i));
        }
    }
    return out;
}

Target marker_map(const ChainResult& chain, const std::string& id) {
    Target out;
    out.id = id;
    out.kind = TargetKind::fixed;
    for (const ChainMarkerResult& m : chain.markers) {
        if (!m.turns) {
            const auto& c = m.covariance.at;
            out.markers.push_back({m.id, m.place, std::sqrt((c[0][0] + c[1][1] + c[2][2]) / 3.0)});
        }
    }
    return out;
}

}  // namespace sc::host
