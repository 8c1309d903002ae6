// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "boards/sim/survey/cell_truth.hpp"

namespace sc::sim {

/// Four sides round the table's axis, each at its own distance and lean, for the head of three lasers: world.toml upon
/// `base` and its mesh; points.csv (facet,c_deg,x_mm,y_mm,z_mm,sigma_um in c, each side in a view of its own, with the
/// table so that it faces the sensor), references.csv and robot.csv of these views.
void write_sides(const CellTruth& truth, const std::filesystem::path& base, const std::filesystem::path& folder);

}  // namespace sc::sim
