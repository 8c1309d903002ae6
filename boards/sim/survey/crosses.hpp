// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "boards/sim/survey/cell_truth.hpp"
#include "boards/sim/world/world.hpp"

namespace sc::sim {

/// The crosses of a pulse trace as one view of the sensor sees them: crosses.csv
/// (no,x,y,z,sigma_x,sigma_y,sigma_z,width, sigma_width; mm, c) in the order of burning, references.csv and robot.csv
/// of that view. A stroke is as wide as its pulses leave a mark: where their fluence is above the surface's threshold.
/// Throws std::runtime_error.
void write_crosses(const CellTruth& truth, const World& world, const std::filesystem::path& trace,
                   const std::filesystem::path& folder);

/// Widths of the strokes of a trace: line,width_mm,sigma_mm in the order of burning (a focus ladder under a
/// microscope).
void write_widths(const CellTruth& truth, const World& world, const std::filesystem::path& trace,
                  const std::filesystem::path& file);

}  // namespace sc::sim
