// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "shared/geometry/vec.hpp"

/// A plate with crosses burnt through the galvo: what was commanded, and what was measured. CSV files, in
/// millimetres (docs/formats.md). In memory all is metres.

namespace sc::host {

struct PlateCross {
    int no = 0;
    std::array<double, 2> command{};  ///< (x, z) of the galvo, before any correction
    Vec3 anchor;                      ///< where the axes stood, h
};
struct MeasuredCross {
    int no = 0;
    Vec3 place;          ///< of the cross on the plate, h
    double sigma = 0.0;  ///< of x and of z
};

/// A cross as the 3-D sensor saw it, in c.
struct SeenCross {
    int no = 0;
    Vec3 place;
    Vec3 sigma;                ///< along x, y, z of c, > 0
    double width = 0.0;        ///< of its strokes; 0: not measured
    double width_sigma = 0.0;  ///< > 0 where a width is given
};

/// Header: no,command_x,command_z,anchor_x,anchor_y,anchor_z. Throws InputError; numbers must not repeat.
[[nodiscard]] std::vector<PlateCross> read_plate_plan(const std::filesystem::path& path);
void write_plate_plan(const std::filesystem::path& path, const std::vector<PlateCross>& crosses);
/// Header: no,x,y,z,sigma. Throws InputError for a number that repeats, a sigma that is not above zero, a place beyond
/// 10 m.
[[nodiscard]] std::vector<MeasuredCross> read_measured_crosses(const std::filesystem::path& path);

/// Header: no,x,y,z,sigma_x,sigma_y,sigma_z and optionally width,sigma_width; millimetres, in c. Throws as above.
[[nodiscard]] std::vector<SeenCross> read_seen_crosses(const std::filesystem::path& path);

}  // namespace sc::host
