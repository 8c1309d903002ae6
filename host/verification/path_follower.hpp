// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/path/job_plan.hpp"
#include "shared/trace/trace.hpp"

namespace sc::host {

/// A free path as burnt, all its passes together, against its plan. Metres.
struct PathAccuracy {
    std::uint32_t path = 0;
    std::string name;
    double face_deg = 0.0;
    std::size_t pulses = 0;
    double max = 0.0;  ///< distance of a pulse (x and z on the surface, y of the focus) from the planned pieces
    double rms = 0.0;
    double largest_gap = 0.0;  ///< along the path without a pulse, ends included
    bool whole = false;        ///< no gap of more than 0.3 mm (a corner at which the beam stops) or three pitches
};

struct FollowedPaths {
    std::vector<PathAccuracy> paths;         ///< all free paths of the plan
    std::vector<trace::PulseRecord> others;  ///< pulses that belong to none, in their order
};

/// Cuts the pulses (in order of time) into runs where the laser went dark, and gives each run to the planned path, of
/// whatever kind, that it lies next to; runs of free paths are judged, the others handed on. A run further than
/// `radius` from every free path is another's. O(pulses × (paths + log pieces)) for paths that do not coil.
[[nodiscard]] FollowedPaths follow_paths(std::span<const trace::PulseRecord> pulses, const AxisLine& axis,
                                         const JobPlan& plan, double radius = 2e-3);

}  // namespace sc::host
