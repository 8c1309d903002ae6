// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "host/calibration/sensor_ray_fit.hpp"

/// Where the Y sensor looks: a scan over planes that the 3-D sensor has measured.

namespace sc::host::cli {

struct YSensorOptions {
    std::filesystem::path out;
    std::optional<std::filesystem::path> calibration;  ///< with h_from_c and axes; the cell's without one
    std::optional<std::filesystem::path> cell;         ///< folder of `calibrate all`: of which the simulated roof is
    std::optional<std::filesystem::path> points;       ///< facet,x_mm,y_mm,z_mm,sigma_um; in c
    std::optional<std::filesystem::path> roughly;      ///< facet,x_mm,y_mm,z_mm: a place on each, h
    std::optional<std::filesystem::path> readings;     ///< of a scan that was made before
    std::string link = "sim:";
    std::optional<std::filesystem::path> key{};  ///< file of the cell's key
    double beside_mm = 30.0;                     ///< the beam's offset from the focus in x, to a millimetre
    double sigma_um = 7.5;                       ///< of the simulated 3-D sensor
    std::uint64_t seed = 1;
    int only_facet = 0;  ///< 0: all
    bool json = false;
};
struct YSensorOutcome {
    SensorRayFit fit;
    CalibrationSet set;
    std::string files;
};
/// Scans through the link (readings.csv, a row as soon as it is taken: a second call goes on), fits, and puts
/// [y_sensor] into the set. Throws InputError, CellError, Interrupted; the cell is left at rest.
[[nodiscard]] YSensorOutcome run_y_sensor(const YSensorOptions& options);
/// The part of it without a cell. `c` brings the points' frame into the set's c.
[[nodiscard]] SensorRayFit fit_y_sensor(const CalibrationSet& set, const std::filesystem::path& points,
                                        const std::filesystem::path& readings,
                                        const Rigid<frame::C, frame::C>& c_from_points = {});
/// The scan alone: readings.csv in `out`.
void scan_roof(const YSensorOptions& options, const std::filesystem::path& roughly,
               const std::optional<std::filesystem::path>& world);

/// The same on the simulated cell's roof, its view brought into the c of a cell that `calibrate all` has calibrated.
[[nodiscard]] SensorRayFit scan_simulated_roof(const YSensorOptions& options, const CalibrationSet& set,
                                               const std::filesystem::path& cell);
[[nodiscard]] SensorRay y_sensor_record(const SensorRayFit& fit, const std::string& time);

}  // namespace sc::host::cli
