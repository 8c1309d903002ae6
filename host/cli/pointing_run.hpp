// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/calibration/step_depths.hpp"
#include "host/cli/jog_moves.hpp"
#include "host/cli/pendant_options.hpp"
#include "host/formats/calibration_set.hpp"
#include "host/formats/target.hpp"

/// Point-to-point: the guide spot is brought onto the cross of one marker after another, by a person or, in the
/// simulated cell, by a program that sees as a person does.

namespace sc::host::cli {

struct PointingOptions {
    std::optional<std::filesystem::path> target;       ///< scribecell-target, kind mobile; the simulated cell has one
    std::optional<std::filesystem::path> calibration;  ///< for the axes; without one they are taken as true
    std::filesystem::path out;
    std::optional<std::filesystem::path> base_world;  ///< the simulated cell's, the target is put into it
    std::optional<std::filesystem::path> keys;        ///< keys in place of a terminal's, or of the simulated person
    PendantWords pendant{};                           ///< in place of them, beside the keys of `verify record`
    std::string link = "sim:";
    std::optional<std::filesystem::path> key{};         ///< file of the cell's key
    std::vector<double> at_mm{-240.0, -250.0, -260.0};  ///< roughly where the target's zero stands in h
    int markers = 12;                                   ///< how many; 0: all
    int looks = 9;                                      ///< at the first marker's focus
    double pointing_um = 10.0;                          ///< noise of an eye across the beam (stated, and simulated)
    double focusing_um = 60.0;                          ///< and along it
    std::uint64_t seed = 1;
    bool json = false;
};

/// One marker, taken.
struct PointedMarker {
    int id = 0;
    Vec3 reading;           ///< of the axes, metres
    double distance = 0.0;  ///< of the Y sensor; 0: it gave none
    double distance_sigma = 0.0;
};
struct PointingOutcome {
    std::vector<PointedMarker> markers;
    double focus_y = 0.0;              ///< of the first marker, h
    double focus_sigma = 0.0;          ///< common to all markers
    std::optional<StepDepths> depths;  ///< none: each marker was focused by eye
    std::filesystem::path h_csv;  ///< id,x_mm,y_mm,z_mm,sigma_x_um,sigma_y_um,sigma_z_um for `calibrate rigid --to`
    bool stopped = false;         ///< by the person, before the last marker
};

/// Where the focus truly stands for readings of the axes (docs/frames.md, errors of the linear axes).
[[nodiscard]] Vec3 focus_of(const CalibrationSet& set, const Vec3& reading);

/// Moves, asks, and writes pointing.csv after each marker, so that a second call goes on behind the last one; h.csv at
/// the end. Throws InputError, CellError, Interrupted; the cell is left at rest.
[[nodiscard]] PointingOutcome run_pointing(const PointingOptions& options);

}  // namespace sc::host::cli
