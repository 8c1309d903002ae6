// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/formats/calibration_set.hpp"

/// The whole calibration of the simulated cell, from nothing to one calibration set, and the paper's experiment with
/// it: 36 markers on four faces are measured, converted, scribed and compared with the truth.

namespace sc::host::cli {

struct AllOptions {
    std::filesystem::path out;
    std::uint64_t seed = 1;
    double sigma_um = 7.5;        ///< of the 3-D sensor
    double pointing_um = 10.0;    ///< of a person's eye
    double robot_bias_mm = 0.35;  ///< errors of the robot's arms
    int across = 5;               ///< crosses of a stand on the block
    int up = 9;
    std::vector<std::string> without;  ///< steps that are left out (kLeavable)
    bool verify = true;
    bool json = false;
    std::function<void(const std::string&)> say = [](const std::string&) {};
};
/// What --without takes: "axes" (they are taken as true), "references" (views by robot and hand-eye alone), "plate"
/// (h_from_c from pointed markers), "axis" (as the drawing has it), "lag", "y-sensor", "triple-head".
[[nodiscard]] const std::vector<std::string>& leavable();

/// Beam against true place over the markers of a face; micrometres.
struct FaceFigures {
    double face_deg = 0.0;
    std::size_t markers = 0;
    double axis_95 = 0.0;  ///< 95 % of |dx|, |dy|, |dz|
    double axis_max = 0.0;
    double place_max = 0.0;  ///< of the distance
};
struct AllOutcome {
    CalibrationSet set;
    std::filesystem::path file;      ///< of the set
    std::vector<FaceFigures> faces;  ///< then one of all, face_deg −1
    nlohmann::ordered_json steps;    ///< what each step said
};

/// Goes on where an earlier call with the same options stopped. Throws InputError (other options in the folder, data
/// that cannot support a step), CellError, Interrupted.
[[nodiscard]] AllOutcome run_all(const AllOptions& options);

}  // namespace sc::host::cli
