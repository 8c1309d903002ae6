// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "host/inspection/inspection.hpp"

namespace sc::host {

/// A scanned place over a face that asks for metal, as the part finally lies.
struct MapPoint {
    Vec3 place;           ///< metres, in w
    Vec3 direction;       ///< unit; the allowance grows fastest this way
    double margin = 0.0;  ///< metres: allowance less what is asked
    std::uint32_t group = 0;
};
/// Every `stride`-th of them.
[[nodiscard]] std::vector<MapPoint> map_points(const Inspection& inspection, const DistanceField& field,
                                               std::size_t stride = 1);

/// Warm: metal to spare; cool: lacking; full colour at ± `scale` metres. Red, green, blue.
[[nodiscard]] std::array<std::uint8_t, 3> map_colour(double margin, double scale) noexcept;

/// All places as a coloured PLY (binary, millimetres): x, y, z, red, green, blue, margin.
void write_map_ply(const std::filesystem::path& file, const Inspection& inspection, const DistanceField& field,
                   double scale);

/// A canvas of points that turns and can be shifted, and the script for it. `scale`: metres at full colour.
[[nodiscard]] std::string map_html(const Inspection& inspection, const DistanceField& field, double scale);

}  // namespace sc::host
