// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/verification/burn_finder.hpp"

namespace sc::host {

/// A pulse on a face, in h with the face at its nominal angle.
struct SurfacePulse {
    std::int64_t t_ns = 0;
    Flat place;
    double surface_y = 0.0;
    double focus_y = 0.0;
    double energy_uj = 0.0;
};

struct StrokeSet {
    std::vector<Stroke> strokes;  ///< in order of their first pulse
    std::size_t stray = 0;
};

/// Cuts the pulses of one face (in order of time) into straight runs by gaps and by direction, joins the runs that
/// belong together (dark stretches, a hold in mid-stroke, several passes), and fits a line to each.
[[nodiscard]] StrokeSet build_strokes(double face_deg, std::span<const SurfacePulse> pulses,
                                      const BurnFinderSettings& settings);

}  // namespace sc::host
