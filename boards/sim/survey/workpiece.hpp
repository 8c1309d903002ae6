// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "boards/sim/survey/cell_truth.hpp"

namespace sc::sim {

/// A box on the table with nine markers on each of its four faces (the paper's experiment): world.toml upon `base` and
/// its mesh, and one view of each face from the robot's side: markers.csv (face k's are numbered 10k/9 + 1 ... ), with
/// the table turned so that the face looks there, references.csv and robot.csv.
void write_workpiece(const CellTruth& truth, const std::filesystem::path& base, const std::filesystem::path& folder);
/// For whoever judges: joins face_deg,no,mx,my,mz (mm) with the true places, as a verification table
/// (face_deg,no,mx,my,mz,tx,ty,tz). `world` is the one that write_workpiece made. Throws std::runtime_error.
void write_judged(const CellTruth& truth, const std::filesystem::path& world, const std::filesystem::path& measured,
                  const std::filesystem::path& file);

}  // namespace sc::sim
