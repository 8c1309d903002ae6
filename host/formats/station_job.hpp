// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "shared/geometry/vec.hpp"

/// What is to become of measured stations: how the workpieces should sit, how well, what they are adjusted with, where
/// the robot sees them. File: format = "scribecell-measure", version = 1 (docs/formats.md). In memory SI.

namespace sc::host {

struct StationTarget {
    bool same = false;      ///< sit as the median of the batch does, instead of the figures below
    double angle = 0.0;     ///< between the planes, radians
    double yaw = 0.0;       ///< about z of r
    double distance = 0.0;  ///< along x of r, at `at`
    bool operator==(const StationTarget&) const noexcept = default;
};
/// An adjusting screw behind the workpiece; it pushes the face along −x of r (towards the head) when turned clockwise.
struct StationScrew {
    std::string id;
    std::array<double, 2> place{};  ///< y, z in r
    double pitch = 0.0;
    bool operator==(const StationScrew&) const noexcept = default;
};
/// One standard deviation of how the magnetic base sits when it is put down again.
struct SeatSigma {
    double angle = 0.0;  ///< about each axis of r
    double place = 0.0;  ///< along each axis of r
    bool operator==(const SeatSigma&) const noexcept = default;
};
struct StationRobot {
    Mat3 rotation;  ///< b_from_r at rail place zero
    Vec3 translation;
    Vec3 rail{1.0, 0.0, 0.0};  ///< direction of the rail in b
    int first_number = 1;      ///< of BASE, UFRAME
};
struct StationJob {
    std::filesystem::path file;
    std::filesystem::path calibration;  ///< may be empty: then the command names it
    std::filesystem::path readings;     ///< may be empty
    std::optional<StationTarget> target;
    std::array<double, 2> at{};  ///< y, z in r: where the distance is taken; pivot of all turning
    bool at_given = false;
    double angle_tolerance = 0.0;
    double distance_tolerance = 0.0;
    std::vector<StationScrew> screws;  ///< none or three
    SeatSigma seat;
    double oldest = 0.2;  ///< s: age at which a reading is stale
    int fewest = 3;       ///< readings a station
    std::optional<StationRobot> robot;
};

/// The job that is used where none is given: no target, no tolerances, a seat without error.
[[nodiscard]] StationJob default_station_job();
/// Throws InputError.
[[nodiscard]] StationJob read_station_job(const std::filesystem::path& path);

}  // namespace sc::host
