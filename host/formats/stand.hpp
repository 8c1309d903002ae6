// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/calibration_set.hpp"

/// A calibration stand for the triple-laser head: plates at certified heights, a camera that sees them, a pattern of
/// dots for its scale. File: format = "scribecell-stand", version = 1 (docs/formats.md). In memory SI.

namespace sc::host {

/// The head as it was drawn.
struct StandSensor {
    std::string id;
    std::array<double, 2> origin{};  ///< where its beam should meet z = 0 of d
};
/// Two adjusting screws a sensor, one for x and one for y.
struct StandMount {
    double arm = 0.0;                   ///< from the pivot to the screw
    double pitch = 0.0;                 ///< of the thread
    bool clockwise_is_positive = true;  ///< turning clockwise tilts the beam towards +x (+y)
};
/// One plate.
struct StandHeight {
    double z = 0.0;                              ///< of the plate, in d
    std::filesystem::path scale_picture;         ///< of the dots on this plate
    std::array<std::filesystem::path, 3> spots;  ///< a picture a sensor
    std::filesystem::path readings;              ///< stations file with the readings of this plate; may be empty
};
struct Stand {
    std::filesystem::path file;
    std::string id;
    std::string time;
    std::array<StandSensor, 3> sensors;
    std::array<double, 2> range{};            ///< least and most reading of the sensors
    double sigma = 0.0;                       ///< of a reading, by its data sheet; replaced by what is seen
    std::vector<std::array<double, 2>> dots;  ///< x, y in d: where the dots are on every plate
    double dot_diameter = 0.0;
    double registration = 0.0;  ///< how well a plate's dots lie where they should, one sigma
    double height_sigma = 0.0;  ///< of a plate's height
    std::optional<StandMount> mount;
    std::optional<TripleReference> reference;  ///< d_from_r by the drawing (CAD)
    double reference_angle_sigma = 0.0;        ///< rad: of the drawing, about each axis
    double reference_place_sigma = 0.0;        ///< metres
    std::vector<StandHeight> heights;          ///< three or more, each z once
};

/// Throws InputError (file, line, value, what to do). Pictures are not read yet.
[[nodiscard]] Stand read_stand(const std::filesystem::path& path);

}  // namespace sc::host
