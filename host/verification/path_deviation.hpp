// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/geometry/vec.hpp"
#include "shared/machine/machine.hpp"

/// How far emitted samples leave the polyline that they were to follow, both ways and in order.

namespace sc::host {

/// Metres. `tolerance`: from a sample to its place on the polyline. `cover`: from a point of the polyline to the chord
/// between the two samples that pass it, less what the motion can bulge between two samples. Rounding a right angle
/// within `tolerance` misses its vertex by up to √2 · tolerance, so `cover` is to be no less than that.
struct PathTolerance {
    double tolerance = 0.0;
    double cover = 0.0;
    bool may_return = false;  ///< places may go back: a hold that is resumed with a run-in
};

/// A matching gives every sample a place on the polyline; places never go back (unless they may), the first is the
/// polyline's start, the last its end, and every vertex lies between the places of two neighbouring samples.
struct PathDeviation {
    bool followed = false;         ///< a matching within both tolerances exists
    bool matched = false;          ///< a matching exists at all; if not, the numbers are of the part before `lost`
    double deviation = 0.0;        ///< metres: largest distance of a sample from its place
    std::size_t sample = 0;        ///< where; index into the samples
    double vertex_miss = 0.0;      ///< metres: largest distance of a vertex from the chord that passes it
    std::size_t vertex = 0;        ///< which; index into the path
    std::size_t miss_sample = 0;   ///< index of the sample at the end of that chord
    double start_gap = 0.0;        ///< metres: first sample to the path's start
    double end_gap = 0.0;          ///< metres: last sample to the path's end
    std::size_t lost_sample = 0;   ///< not matched: the first sample for which there is no place
    std::size_t lost_vertex = 0;   ///< not matched: the last vertex that was passed before
    double lost_distance = 0.0;    ///< metres: from that sample to the nearest place further on
    std::vector<float> of_sample;  ///< metres, one a sample; NaN from lost_sample on
};

/// The decision is exact: it keeps all places that a sample may have (a free-space diagram, as for the Fréchet
/// distance) and so does not depend on a good guess where lines cross, come near or double back. Where no matching
/// within the tolerances exists it is looked for with larger ones, up to some 60 times, so that the numbers say what
/// was missed.
///
/// X, Y, Z of `samples` in pm; `path` in metres, at least two points, taken to the nearest pm. Cost: linear in samples
/// and points while neighbouring points are no nearer than the tolerance (100 000 samples, 20 000 points: 0.1 s); each
/// sample costs as many steps as segments lie within the tolerance of it. Samples that stand still cost nothing. Throws
/// InputError for fewer points, for points that are no place and when the decision would take over 150 MB.
[[nodiscard]] PathDeviation path_deviation(std::span<const AxisPositions> samples, std::span<const Vec3> path,
                                           const PathTolerance& tolerance);

}  // namespace sc::host
