// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "host/path/curve.hpp"
#include "host/path/stage_fit.hpp"
#include "shared/machine/galvo_field.hpp"
#include "shared/path/item.hpp"

/// Several lines as one path of the mirrors: marked one after the other at full speed, with a dark run-out, jump and
/// run-in between. Of a split path, with the stage's curve.

namespace sc::host {

/// A line that is marked in one go.
using Stroke3 = std::vector<Piece>;

struct StrokePath {
    std::vector<Item> items;
    double length = 0.0;       ///< metres, with run-in, run-out and jumps
    double dark_length = 0.0;  ///< of it
    StageFit stage;            ///< of a split path
};

/// `begin` says how; its actuator is galvo or split. Each stroke has at least one piece, each piece a length, and each
/// goes on where the one before ends. Split: the path may not be possible; then stage.worst > 1 + kStageSlack, and the
/// controller would refuse it. `depth`: metres that the surface may lie off the focus. Throws nothing.
[[nodiscard]] StrokePath stroke_path(const PathBegin& begin, std::span<const Stroke3> strokes,
                                     const MachineConfig& machine, double depth = GalvoField::kDepthMost);

/// As stroke_path, at the greatest speed up to that of `begin`, and down to a quarter of it, at which there is a curve
/// for the stage: pitch and energy of the pulses stay. The speed stands in the items' PathBegin; none is found if
/// stage.worst says so. A few seconds for a thousand lines.
[[nodiscard]] StrokePath split_path(const PathBegin& begin, std::span<const Stroke3> strokes,
                                    const MachineConfig& machine, double depth = GalvoField::kDepthMost);

}  // namespace sc::host
