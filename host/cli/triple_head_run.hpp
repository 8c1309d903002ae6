// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "host/calibration/sensor_ray_fit.hpp"
#include "host/cli/known_faces.hpp"

/// Where the three beams of the triple head lie in h: readings over faces on the turntable that the 3-D sensor has
/// measured, turned before the head.

namespace sc::host::cli {

struct TripleHeadOptions {
    std::filesystem::path out;
    std::optional<std::filesystem::path> calibration;  ///< with h_from_c and turntable; the cell's without one
    std::optional<std::filesystem::path> cell;         ///< folder of `calibrate all`: of which the simulated sides are
    std::optional<std::filesystem::path> points;       ///< facet,c_deg,x_mm,y_mm,z_mm,sigma_um; in c
    std::optional<std::filesystem::path> angles;       ///< facet,c_deg: where which face stands before the head
    std::optional<std::filesystem::path> readings;     ///< of a scan that was made before
    std::string link = "sim:";
    std::optional<std::filesystem::path> key{};  ///< file of the cell's key
    double looks_deg = 180.0;                    ///< direction of the beams in the x-y plane of h, from +x
    double accuracy_um = 40.0;                   ///< of the beams, beyond their noise
    double sigma_um = 7.5;                       ///< of the simulated 3-D sensor
    std::uint64_t seed = 1;
    bool json = false;
};
struct TripleHeadFit {
    std::array<SensorRayFit, 3> rays;
};
struct TripleHeadOutcome {
    TripleHeadFit fit;
    CalibrationSet set;
    std::string files;
};

/// Turns the table and reads (readings.csv, a row as soon as it is taken: a second call goes on), fits, and puts
/// [[triple_head]] into the set. Throws InputError, CellError, Interrupted; the cell is left at rest.
[[nodiscard]] TripleHeadOutcome run_triple_head(const TripleHeadOptions& options);
/// The part of it without a cell: readings are sensor,facet,c_deg,reading_mm,sigma_mm; sensor 1 to 3. `accuracy`:
/// metres, 1 sigma, of what all readings over a face have in common.
[[nodiscard]] TripleHeadFit fit_triple_head(const KnownFaces& faces, const std::filesystem::path& readings,
                                            double looks_deg, double accuracy);
/// The same on sides in the simulated cell, brought into the c of a cell that `calibrate all` has calibrated.
[[nodiscard]] TripleHeadFit scan_simulated_sides(const TripleHeadOptions& options, const CalibrationSet& set,
                                                 const std::filesystem::path& cell);
void put_triple_head(CalibrationSet& set, const TripleHeadFit& fit, const std::string& time);

}  // namespace sc::host::cli
