// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sc::host {

/// One figure of a station, for the table `measurements` of the project's SQLite file.
struct StationFigure {
    std::string station;
    std::string quantity;  ///< "angle", "about_y", "about_z", "distance"; of a refused station: the problem's name
    double value = 0.0;
    double sigma = 0.0;
    std::string unit;  ///< "deg", "mm"; empty: refused
};

/// Adds all figures in one transaction: kind "station", or "station_refused" where the unit is empty. `time`: ISO 8601,
/// UTC; `calibration`: sha256 of the set. Throws InputError and DatabaseError as Database does.
void log_stations(const std::filesystem::path& database, const std::string& time, const std::string& calibration,
                  const std::vector<StationFigure>& figures);

}  // namespace sc::host
