// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "boards/sim/survey/cell_truth.hpp"
#include "boards/sim/world/world.hpp"

namespace sc::sim {

/// Fifteen views of a fixed target: markers.csv, references.csv, robot.csv.
void write_fixed_target(const CellTruth& truth, const std::filesystem::path& folder);
/// Twelve views round the table of the reference markers alone: the same three files.
void write_ring(const CellTruth& truth, const std::filesystem::path& folder);
/// Markers on a board that leans on the table, at `angles` readings of C over `arc` degrees: the same three files.
void write_table_markers(const CellTruth& truth, const World& world, int angles, double arc_deg,
                         const std::filesystem::path& folder);
/// An interferometer at the axes: x,y,z,dir_x,dir_y,dir_z,true_x,true_y,true_z (mm), with 0.5 um of noise.
void write_axes(const CellTruth& truth, const World& world, const std::filesystem::path& file);

/// The mobile target before the head: three steps, one above the other, a little askew. Places in h at C = 0.
struct MobileTarget {
    struct Marker {
        int id = 0;
        std::size_t step = 0;
        Vec3 place;
    };
    std::vector<Marker> markers;
    Pose h_from_m;
    std::array<double, 3> height{};     ///< true
    std::array<double, 3> certified{};  ///< as its certificate says
    explicit MobileTarget(const CellTruth& truth);
    /// Where a ray along −y from beside the head meets it: y in h. Throws std::runtime_error beside it.
    [[nodiscard]] double surface_y(double x, double z) const;
};
/// target.toml, and one view of it: markers.csv, references.csv, robot.csv; world.toml and its mesh upon `base`, for
/// the cell's own distance sensor.
void write_mobile_target(const CellTruth& truth, const std::filesystem::path& base,
                         const std::filesystem::path& folder);

/// A roof of five faces before the head, flat and leaning in x and in z: world.toml upon `base` and its mesh,
/// points.csv (facet,x_mm,y_mm,z_mm,sigma_um in c, from one view) and roughly.csv (facet,x_mm,y_mm,z_mm in h, a place
/// on each).
void write_roof(const CellTruth& truth, const std::filesystem::path& base, const std::filesystem::path& folder);

/// What a person sees with the axes at a reading: how far the guide spot is from the marker (metres, x and z) and how
/// far the surface is from the focus as its sharpness tells it (y), each with the noise of an eye.
struct SpotSeen {
    Vec3 off;
};
[[nodiscard]] SpotSeen see_spot(const CellTruth& truth, const World& world, int marker, const Vec3& reading,
                                double pointing, double focusing, std::uint64_t look);

}  // namespace sc::sim
