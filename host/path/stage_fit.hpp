// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "host/path/profile.hpp"
#include "shared/geometry/vec.hpp"
#include "shared/machine/machine.hpp"

/// Where the stage is to be while the mirrors follow a path: the smoothest uniform cubic B-spline over path distance
/// from which the mirrors reach every place, and along which the stage keeps its share of the limits. Metres, seconds.

namespace sc::host {

/// A place of the path at its distance from the start of the run-in.
struct StagePlace {
    double distance = 0.0;
    Vec3 place;
    bool marked = true;  ///< or passed dark, where depth does not matter
};

struct StageRules {
    double speed = 0.0;    ///< of the path
    double spacing = 0.0;  ///< of knots, path distance
    double lag = 0.0;      ///< path distance: the stage may be so far behind on its curve, or not at all
    Vec3 reach;            ///< of the mirrors either way, and of the depth (y)
    Vec3 low;              ///< of the travel, a margin inside
    Vec3 high;
    std::array<MoveLimits, 3> limits{};  ///< along the curve at the path's speed
};
/// For this machine and path speed. What is left to the limits is for how the stage follows (docs/link.md), and a
/// margin of 2 mm in the field, 0.5 mm in depth is for what the path's length is not known by. `depth`: metres that the
/// surface may lie off the focus, if that is less.
[[nodiscard]] StageRules stage_rules(double speed, const MachineConfig& machine, double depth);

struct StageFit {
    std::vector<Vec3> control;  ///< control points; knot i lies at i · spacing
    /// Largest share of a rule: 1 is at it. More than 1 + kStageSlack: there is no such curve.
    double worst = 0.0;
    double worst_distance = 0.0;
    /// The surface is within so much of the focus wherever it is marked, but for the first 0.1 s behind a hold: the
    /// narrowest of kDepthWindows that is possible, or the reach.
    double depth_window = 0.0;
    bool by_reach = false;  ///< the worst is the mirrors' reach, not the stage's motion or travel
};
inline constexpr double kStageSlack = 0.01;
/// Metres. A spot of 33 µm at 1064 nm and M² 1.5 loses 3 % of its fluence in 0.1 mm, 24 % in 0.3 mm.
inline constexpr std::array<double, 4> kDepthWindows{0.1e-3, 0.3e-3, 1e-3, 3e-3};

/// `count` control points, at least 4. Minimises the curve's second differences, and a little the mirrors' share, under
/// the rules; alternating directions (Boyd et al. 2011, Found. Trends Mach. Learn. 3, 1) on each axis by itself.
/// Deterministic. Some 0.2 s for 1 000 control points.
[[nodiscard]] StageFit fit_stage(std::span<const StagePlace> places, std::size_t count, const StageRules& rules);
/// Place of the curve at a distance, held to its ends.
[[nodiscard]] Vec3 stage_at(std::span<const Vec3> control, double spacing, double distance);

}  // namespace sc::host
