// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host/verification/line_fit.hpp"
#include "shared/geometry/frames.hpp"
#include "shared/trace/trace.hpp"

/// Finds what was burnt from where the pulses met the surface. Knows nothing of the job: not how many strokes there
/// are, nor where, nor in which order.

namespace sc::host {

/// A straight stroke on one face, all its passes together. Places in h with the face at its nominal angle.
struct Stroke {
    double face_deg = 0.0;
    FlatLine line;        ///< across the beam
    Trend surface_depth;  ///< y of the surface by place along the line
    Trend focus_depth;    ///< y of the focus: the surface's plus the defocus there
    double z_min = 0.0;   ///< of the pulses that count
    double z_max = 0.0;
    std::size_t pulses = 0;
    std::size_t outliers = 0;  ///< of them, too far off the line to count
    double energy_uj = 0.0;    ///< mean of one pulse
    std::int64_t first_ns = 0;
    std::int64_t last_ns = 0;
};

/// Two strokes that cross at right angles.
struct FoundCross {
    double face_deg = 0.0;
    Point<frame::H> place;     ///< x, z of the crossing; y of the focus there
    double surface_y = 0.0;    ///< of the surface at the crossing
    double sigma = 0.0;        ///< standard deviation of x and of z from the scatter of the pulses, metres
    double squareness = 0.0;   ///< angle between the strokes less a right one, rad
    std::size_t stroke_a = 0;  ///< indices in BurnFindings::strokes; a is the one nearer to x
    std::size_t stroke_b = 0;
};

/// A stroke of `long_line` or more.
struct FoundLine {
    double face_deg = 0.0;
    Point<frame::H> from;  ///< ends by x; y of the focus
    Point<frame::H> to;
    double length = 0.0;
    double straightness = 0.0;  ///< width of the narrowest strip along the fitted line that holds its pulses (x, z)
    double z_range = 0.0;       ///< greatest minus least z of its pulses
    std::size_t stroke = 0;
};

struct BurnFindings {
    std::vector<Stroke> strokes;
    std::vector<FoundCross> crosses;  ///< ordered by face, then time
    std::vector<FoundLine> lines;
    std::size_t pulses = 0;          ///< all records
    std::size_t missed = 0;          ///< pulses that met no surface
    std::size_t off_face = 0;        ///< fired at no known face's angle
    std::size_t stray = 0;           ///< belong to no stroke
    std::vector<std::size_t> alone;  ///< short strokes without a partner
};

struct BurnFinderSettings {
    double angle_window_deg = 1.0;  ///< true C against a face's nominal C
    double largest_gap = 1.0e-3;    ///< between pulses of one stroke; three typical distances if that is more
    double off_line = 0.15e-3;      ///< a pulse further off begins another stroke
    double unlit_gap = 3.0e-3;      ///< a stroke may have a dark stretch that the beam crossed without a pause
    double shortest = 0.3e-3;       ///< shorter runs of pulses are stray
    std::size_t fewest_pulses = 4;
    double long_line = 20.0e-3;
    double right_angle_window = 0.05;  ///< rad
};

/// `axis` is the turntable's axis, `face_angles` the faces that may occur (degrees, as in the verification table). The
/// pulses must be in order of time. O(pulses) + O(strokes²).
[[nodiscard]] BurnFindings find_burns(std::span<const trace::PulseRecord> pulses, const AxisLine& axis,
                                      std::span<const double> face_angles, const BurnFinderSettings& settings = {});

}  // namespace sc::host
