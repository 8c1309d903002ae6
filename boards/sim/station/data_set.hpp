// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "boards/sim/station/triple_head.hpp"

/// Files for one head: what a workshop would have, and beside it the truth for whoever judges.

namespace sc::sim {

struct DataSetOptions {
    std::uint64_t seed = 1;
    double side = 0.1;      ///< metres, of the triangle
    double sigma = 0.1e-3;  ///< of a reading
    double distance = 0.3;  ///< of the workpieces
    int readings = 10;      ///< a station
    int repeats = 1;        ///< stations at each angle
    std::vector<double> angles_deg{60.0, 65.0, 70.0, 75.0, 80.0, 85.0, 90.0};
    double seat_angle = 0.0;  ///< rad: the base is put down again for every station
    double seat_place = 0.0;
    bool pictures = true;
    HeadErrors errors;
};

/// Writes into `folder`: stand.toml with plates' readings (plate_N.csv) and pictures (plate_N_*.pgm); known.csv and
/// known_readings.csv, stations at known angles that are none of `angles_deg`; stations.csv; truth.csv
/// (station,angle_deg,yaw_deg,distance_mm) and head_truth.json. Throws std::runtime_error.
void write_data_set(const std::filesystem::path& folder, const DataSetOptions& options);

/// Writes `count` spot pictures (spot_NNN.pgm) with tilt, saturation, speckle and background, and truth.csv
/// (picture,x_px,y_px,waist_px,stretch,peak,speckle,background).
void write_spots(const std::filesystem::path& folder, int count, std::uint64_t seed);

}  // namespace sc::sim
