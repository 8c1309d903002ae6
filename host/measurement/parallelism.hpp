// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "host/formats/stand.hpp"
#include "host/formats/stations.hpp"

/// Calibration of the triple-laser head on its stand: camera scale at each plate, beams from the spots' places at
/// three heights or more, gain and zero from the readings there. Equal triangles at all heights prove the beams
/// parallel to each other; that the triangle does not drift proves them perpendicular to the plates. Both are said.

namespace sc::host {

/// What the pictures of one plate gave; pixels, y down.
struct PlatePixels {
    double z = 0.0;
    std::vector<std::array<double, 2>> dots;  ///< in any order; as many as the stand has
    std::array<std::array<double, 2>, 3> spots{};
    double spot_sigma = 0.0;  ///< px, worst of the three
};

/// Camera scale at one plate.
struct PlateScale {
    double z = 0.0;
    std::array<double, 2> px_per_mm{};             ///< along x and y of d, at the middle of the spots
    double residual = 0.0;                         ///< rms of the dots from their places, metres
    std::array<std::array<double, 2>, 3> spots{};  ///< in d, metres
    std::array<double, 3> side{};                  ///< of the triangle: 1-2, 2-3, 3-1
    std::array<double, 2> middle{};                ///< of the triangle
    double spot_sigma = 0.0;                       ///< metres
};

/// One screw: how far, to make a beam perpendicular.
struct MountTurn {
    std::string sensor;
    char axis = 'x';
    double tilt = 0.0;   ///< rad, as found
    double turns = 0.0;  ///< clockwise positive, to bring the beam upright
};

struct Parallelism {
    std::vector<PlateScale> plates;
    std::array<double, 3> side_drift{};  ///< of sides 1-2, 2-3, 3-1 per height, m/m: what is left of parallelism
    std::array<double, 3> side_drift_sigma{};
    std::array<double, 3> between{};  ///< angles between beams 1-2, 2-3, 3-1, rad
    std::array<double, 2> drift{};    ///< of the triangle's middle per height: what is left of perpendicularity
    double drift_sigma = 0.0;
    std::array<std::array<double, 2>, 3> tilt_sigma{};
    double place_rms = 0.0;             ///< of the spots from their beams, metres
    std::optional<double> reading_rms;  ///< of the readings from their lines
    std::vector<MountTurn> turns;       ///< where the stand names a mount
    TripleRecord head;                  ///< what is left, for the software to take out
};

/// Parts of the calibration that can be left out, to see what each earns.
struct ParallelismParts {
    bool gain = true;
    bool tilt = true;
    bool spots = true;
};

/// `readings`: of the plates, in the order of stand.heights; a plate without has no stations. Throws InputError naming
/// the stand's file: spots that are nearer to another sensor's place (swapped), spots on a line, dots that do not fit
/// their pattern, beams too far from straight, readings that do not go with the heights.
[[nodiscard]] Parallelism fit_parallelism(const Stand& stand, const std::vector<PlatePixels>& plates,
                                          const std::vector<StationFile>& readings, const ParallelismParts& parts = {});

/// The head as the stand's file draws it: no tilt, no gain, no zero; nothing calibrated.
[[nodiscard]] TripleRecord drawn_head_of(const Stand& stand);

/// The head's rays in h, for a head that rides beside the galvo: gains are folded in at the reading `at`.
[[nodiscard]] std::vector<SensorRay> rays_in_h(const TripleRecord& head, const TransformRecord& h_from_d, double at);

}  // namespace sc::host
