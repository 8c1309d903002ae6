// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/calibration/lag_fit.hpp"
#include "host/formats/calibration_set.hpp"
#include "shared/machine/galvo_field.hpp"

namespace sc::host::cli {

/// What `scribecell calibrate galvo-lag` was asked for.
struct GalvoLagOptions {
    std::optional<std::filesystem::path> measured;     ///< a real plate's marks; needs `plan`
    std::optional<std::filesystem::path> plan;         ///< the plan that it was burnt by
    std::optional<std::filesystem::path> calibration;  ///< set to extend; the example's without one
    std::optional<std::filesystem::path> out;          ///< folder for plan.csv, measured.csv, calibration.toml
    std::optional<std::filesystem::path> world;        ///< of the simulated cell
    std::vector<std::string> machine;                  ///< settings of the simulated cell's controller
    std::string link = "sim:";
    std::optional<std::filesystem::path> key;  ///< file of the cell's key
    double sigma_um = 7.5;                     ///< of the simulated measurement
    std::uint64_t seed = 1;
    bool plan_only = false;
    bool json = false;
};

struct GalvoLagOutcome {
    LagFit fit;
    GalvoLag told;       ///< the lag that was in force while the lines were burnt
    CalibrationSet set;  ///< with the new record
    std::string files;   ///< where they are, for a person; empty: nothing was kept
};

/// Burns the lines through `link` with this field correction and the machine's own lag in force, and writes plan.csv
/// and, in the simulated cell, pulses.trace to `folder`. Throws InputError, CellError and what Session throws.
void burn_lag_plate(const GalvoLagOptions& options, const CalibrationSet& set, const GalvoField& field,
                    const std::filesystem::path& folder);
/// The simulated measurement of a burnt plate: runs scribecell-plate-camera. Throws CellError.
void measure_lag_plate(const std::filesystem::path& folder, double sigma_um, std::uint64_t seed,
                       const std::filesystem::path& out);
/// Fits plan and measurement, and adds `galvo_lag` to the set. Throws InputError.
[[nodiscard]] GalvoLagOutcome fit_lag_plate(const std::filesystem::path& plan, const std::filesystem::path& measured,
                                            const CalibrationSet& set);
/// The whole command but for printing.
[[nodiscard]] GalvoLagOutcome run_galvo_lag(const GalvoLagOptions& options);

}  // namespace sc::host::cli
