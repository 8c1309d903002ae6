// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "host/calibration/plate_fit.hpp"
#include "host/formats/calibration_set.hpp"
#include "host/path/plate_plan.hpp"

namespace sc::host::cli {

/// What `scribecell calibrate plate` was asked for.
struct PlateOptionsAsked {
    std::optional<std::filesystem::path> measured;     ///< crosses in c; needs `plan`
    std::optional<std::filesystem::path> plan;         ///< the plan that they were burnt by
    std::optional<std::filesystem::path> calibration;  ///< set to extend; the example's without one
    std::optional<std::filesystem::path> faces;        ///< of the block; the simulated cell's without one
    std::optional<std::filesystem::path> out;          ///< folder
    std::optional<std::filesystem::path> world;        ///< of the simulated cell
    std::string link = "sim:";
    std::optional<std::filesystem::path> key{};  ///< file of the cell's key
    double sigma_um = 7.5;                       ///< of the simulated sensor
    std::uint64_t seed = 1;
    int across = 5;  ///< crosses of a stand
    int up = 9;
    bool plan_only = false;
    bool residual_grid = true;
    bool widths = true;
    bool json = false;
};

struct PlateOutcome {
    PlateFit fit;
    CalibrationSet set;  ///< with h_from_c, galvo, galvo_field and beam
    std::string files;   ///< where they are, for a person; empty: nothing was kept
};

/// step,x_from,x_to,z_from,z_to,y; mm in h. Throws InputError.
[[nodiscard]] std::vector<StepFace> read_step_faces(const std::filesystem::path& file);
/// Pairs plan and measurement. Throws InputError.
[[nodiscard]] std::vector<PlateSight> plate_sights(const std::filesystem::path& plan,
                                                   const std::filesystem::path& measured);
/// The set with what the fit found in place of what it had; `data` names where it came from.
[[nodiscard]] CalibrationSet with_plate(CalibrationSet set, const PlateFit& fit, const std::string& data);
/// Burns the block and has it measured: plan.csv and seen/crosses.csv in `folder`. Throws InputError and CellError.
void burn_steps(const PlateOptionsAsked& options, const CalibrationSet& set, const std::filesystem::path& folder);
/// The whole command but for printing.
[[nodiscard]] PlateOutcome run_plate(const PlateOptionsAsked& options);

}  // namespace sc::host::cli
