// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/view_stitch.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "host/calibration/rigid_fit.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr std::size_t kLeastCommon = 4;
constexpr int kRounds = 40;

std::vector<SeenMarker> cloud(const std::map<int, Vec3>& map) {
    std::vector<SeenMarker> out;
    for (const auto& [id, place] : map) {
        // The map is an average over views: its noise shrinks with them, a view's own does not.
        out.push_back({0, id, place, {1e-9, 1e-9, 1e-9}});
    }
    return out;
}

std::size_t common(const std::map<int, Vec3>& map, const MarkerView& view) {
    return static_cast<std::size_t>(
        std::ranges::count_if(view.markers, [&map](const SeenMarker& m) { return map.contains(m.id); }));
}

StitchedView stitched(const std::filesystem::path& file, const std::map<int, Vec3>& map, const MarkerView& view) {
    const RigidFit fit = fit_rigid(file, cloud(map), view.markers);
    StitchedView out{{fit.rotation, fit.translation}, fit.covariance, fit.rms, {}};
    for (const RigidMarker& marker : fit.markers) {
        if (!marker.used) {
            out.wrong.push_back(marker.id);
        }
    }
    return out;
}

/// Adds what each view sees to the middle of each marker.
std::map<int, Vec3> middles(const std::vector<MarkerView>& views, const std::map<std::string, StitchedView>& placed) {
    struct Sum {
        Vec3 place;
        double weight = 0.0;
    };
    std::map<int, Sum> sums;
    for (const MarkerView& view : views) {
        const auto at = placed.find(view.view);
        if (at == placed.end()) {
            continue;
        }
        for (const SeenMarker& marker : view.markers) {
            if (std::ranges::count(at->second.wrong, marker.id) == 0) {
                Sum& sum = sums[marker.id];
                sum.place = sum.place + (at->second.c_from_view * Point<frame::C>{marker.place}).v;
                sum.weight += 1.0;
            }
        }
    }
    std::map<int, Vec3> out;
    for (const auto& [id, sum] : sums) {
        out[id] = (1.0 / sum.weight) * sum.place;
    }
    return out;
}

}  // namespace

Stitch stitch_views(const std::filesystem::path& file, const std::vector<MarkerView>& views) {
    Stitch out;
    if (views.empty()) {
        throw InputError({.file = file.string(), .problem = "has no view", .value = {}, .action = "give two or more"});
    }
    out.views[views.front().view] = {};
    out.references = middles(views, out.views);
    // The view that shares most comes next.
    while (out.views.size() < views.size()) {
        const MarkerView* best = nullptr;
        for (const MarkerView& view : views) {
            if (!out.views.contains(view.view) &&
                (best == nullptr || common(out.references, view) > common(out.references, *best))) {
                best = &view;
            }
        }
        if (best == nullptr || common(out.references, *best) < kLeastCommon) {
            throw InputError({.file = file.string(),
                              .line = best != nullptr ? best->line : 0,
                              .problem = "a view shares fewer than four reference markers with the others",
                              .value = best != nullptr ? best->view : "a view appears twice",
                              .action = "take views in between, or stick on more markers"});
        }
        out.views[best->view] = stitched(file, out.references, *best);
        out.references = middles(views, out.views);
    }
    for (int round = 0; round < kRounds; ++round) {
        double moved = 0.0;
        for (std::size_t i = 1; i < views.size(); ++i) {
            StitchedView next = stitched(file, out.references, views[i]);
            moved =
                std::max(moved, norm(next.c_from_view.translation - out.views[views[i].view].c_from_view.translation));
            out.views[views[i].view] = std::move(next);
        }
        out.references = middles(views, out.views);
        if (moved < 1e-9) {
            break;
        }
    }
    double squares = 0.0;
    for (const auto& [name, view] : out.views) {
        squares += view.rms * view.rms;
    }
    out.rms = std::sqrt(squares / static_cast<double>(out.views.size()));
    return out;
}

}  // namespace sc::host
