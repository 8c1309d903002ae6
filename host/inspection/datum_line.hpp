// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "host/formats/part.hpp"
#include "host/inspection/distance_field.hpp"
#include "host/inspection/section.hpp"

namespace sc::host {

/// Where a datum line is to be burnt: on the measured surface.
struct LinePlace {
    Vec3 place;          ///< metres, in the frame of the cloud
    Vec3 normal;         ///< unit, out of the metal
    double sigma = 0.0;  ///< metres: standard deviation of its height over the metal, from how the points scatter there
};
/// One stretch without a gap. Seen against the plane's normal the metal lies on its left.
struct LineRun {
    std::vector<LinePlace> places;  ///< of a closed one the first is not repeated
    bool closed = false;
    double length = 0.0;  ///< metres
};
/// Where the scan shows nothing: never bridged.
struct LineGap {
    Vec3 from;
    Vec3 to;
    double length = 0.0;  ///< metres, straight
};
struct CutLine {
    std::vector<LineRun> runs;  ///< the longest first
    std::vector<LineGap> gaps;
    double length = 0.0;           ///< metres, of all runs
    double reach = 0.0;            ///< metres: over points within it each place is averaged
    std::size_t points = 0;        ///< of the cloud, that the line is made from
    std::size_t left_out = 0;      ///< near the plane, but alone or off the surface that their neighbours make
    std::size_t short_pieces = 0;  ///< shorter than `least_length`: dropped
};

struct CutOptions {
    double gap = 2e-3;           ///< metres without a point that are no gap yet
    double chord = 6e-6;         ///< metres: how far the straight pieces may lie off the places that were measured
    double least_length = 2e-3;  ///< metres: shorter runs are dirt
    double reach = 0.0;          ///< metres; 0 = from the density: some thirty points
    unsigned threads = 0;
};

/// Cuts a cloud with a plane. `outwards` says for a point of the cloud (by index) roughly which way is out of the
/// metal; it is asked near the plane alone. At each place a quadratic surface is fitted to the points about it that
/// belong to the same face (normals alike), so edges stay sharp and noise is averaged out. A million points: some 0.1 s
/// a plane. Without any point near the plane the answer is empty.
[[nodiscard]] CutLine cut_line(std::span<const Vec3> cloud, const std::function<Vec3(std::uint32_t)>& outwards,
                               const Plane& plane, const CutOptions& options = {});

/// A datum plane's line on the scanned blank, all in w.
struct DatumLine {
    std::string id;
    Plane plane;
    CutLine cut;
    double cad_length = 0.0;  ///< metres: the same plane through the CAD model, bores and cavities too
    std::vector<std::string> notes;
};
/// `places` are the scan's points in w, as the part finally lies. Throws InspectionError for a plane that misses the
/// part, and where the scan shows less than a tenth of the line.
[[nodiscard]] DatumLine datum_line(const DistanceField& field, std::span<const Vec3> places, const DatumPlane& datum,
                                   const CutOptions& options = {});

}  // namespace sc::host
