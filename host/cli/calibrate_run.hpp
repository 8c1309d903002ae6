// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "host/calibration/galvo_fit.hpp"
#include "host/formats/calibration_set.hpp"
#include "host/path/plate_plan.hpp"

namespace sc::host::cli {

/// What `scribecell calibrate galvo-field` was asked for.
struct GalvoFieldOptions {
    std::optional<std::filesystem::path> measured;     ///< a real plate's crosses; needs `plan`
    std::optional<std::filesystem::path> plan;         ///< the plan that it was burnt by
    std::optional<std::filesystem::path> calibration;  ///< set to extend; the example's without one
    std::optional<std::filesystem::path> out;          ///< folder for plan.csv, measured.csv, calibration.toml
    std::optional<std::filesystem::path> world;        ///< of the simulated cell
    std::string link = "sim:";
    std::optional<std::filesystem::path> key;  ///< file of the cell's key
    double sigma_um = 7.5;                     ///< of the simulated measurement
    std::uint64_t seed = 1;
    bool plan_only = false;
    bool residual_grid = true;
    bool json = false;
};

struct GalvoFieldOutcome {
    GalvoFit fit;
    CalibrationSet set;  ///< with the new records
    std::size_t crosses = 0;
    std::string files;  ///< where they are, for a person; empty: nothing was kept
};

/// One of the project's own files. Throws InputError.
[[nodiscard]] std::filesystem::path in_project(const char* path);
/// Now, ISO 8601, UTC.
[[nodiscard]] std::string now_text();

/// Where crosses are burnt.
struct CrossBurn {
    std::string link = "sim:";
    std::filesystem::path world;  ///< of the simulated cell
    std::uint64_t seed = 1;
    std::optional<std::filesystem::path> key{};  ///< file of the cell's key
};
/// Burns the crosses of a plan through the link, with the axes as the set has them and an ideal head's field in place
/// of the galvo's correction, and writes plan.csv and, in the simulated cell, pulses.trace to `folder`. Throws
/// InputError, CellError and what Session throws.
void burn_crosses(const CrossBurn& burn, const CalibrationSet& set,
                  const std::function<PlatePlan(const MachineConfig&)>& planner, const std::filesystem::path& folder);

/// Burns the plate of crosses through `link`, with no field correction, and writes plan.csv and, in the simulated cell,
/// pulses.trace to `folder`. Throws InputError, CellError and what Session throws.
void burn_plate(const GalvoFieldOptions& options, const CalibrationSet& set, const std::filesystem::path& folder);
/// The simulated measurement of a burnt plate: runs scribecell-plate-camera. Throws CellError.
void measure_plate(const std::filesystem::path& folder, double sigma_um, std::uint64_t seed,
                   const std::filesystem::path& out);
/// Fits plan and measurement, and adds `galvo` and `galvo_field` to the set. Throws InputError.
[[nodiscard]] GalvoFieldOutcome fit_plate(const std::filesystem::path& plan, const std::filesystem::path& measured,
                                          const CalibrationSet& set, const GalvoFitOptions& options);
/// The whole command but for printing.
[[nodiscard]] GalvoFieldOutcome run_galvo_field(const GalvoFieldOptions& options);

}  // namespace sc::host::cli
