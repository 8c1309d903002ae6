// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/geometry/vec.hpp"

/// Readings of the triple-laser head, station after station along the rail, and stations whose pose is known
/// (docs/formats.md). In memory SI: metres, radians, seconds.

namespace sc::host {

/// How the head stands off the place where it is seated: a point of the head is at shift + Rz·Ry·Rx·point of d.
struct HeadPose {
    Vec3 shift;
    Vec3 tilt;  ///< about x, y, z of d
    bool operator==(const HeadPose&) const noexcept = default;
};

struct HeadReading {
    int line = 0;                   ///< in the file
    std::array<double, 3> value{};  ///< as the sensors gave them, metres
    std::optional<double> age;      ///< of the oldest of the three when it was taken over
    std::string fault;              ///< what the sensors said of themselves; empty: nothing
    HeadPose pose;
    bool operator==(const HeadReading&) const = default;
};

struct Station {
    std::string id;
    std::optional<double> rail;          ///< place of the carriage
    std::array<std::string, 3> sensors;  ///< ids in the order of the readings; empty: the file does not say
    std::vector<HeadReading> readings;   ///< at least one
    bool operator==(const Station&) const = default;
};

struct StationFile {
    std::filesystem::path file;
    std::vector<Station> stations;  ///< in the order in which they first appear
};

/// CSV with station,d1_mm,d2_mm,d3_mm and any of: rail_mm, age_ms, fault, sensors (three ids, blanks between),
/// shift_x_mm, shift_y_mm, shift_z_mm, tilt_x_deg, tilt_y_deg, tilt_z_deg. A row a reading; rows of a station need not
/// follow each other. TOML (ends in .toml, format = "scribecell-stations") holds the same as [[station]]. Throws
/// InputError for all that is malformed.
[[nodiscard]] StationFile read_stations(const std::filesystem::path& path);
/// CSV in memory; `path` for messages, `first_line` the line of the header's successor when rows come one at a time.
[[nodiscard]] StationFile parse_stations(const std::filesystem::path& path, std::string_view text);

/// A station whose pose against the reference is known from elsewhere.
struct KnownPose {
    std::string station;
    double angle = 0.0;  ///< between the planes, radians
    double angle_sigma = 0.0;
    std::optional<double> yaw;  ///< about z of r
    double yaw_sigma = 0.0;
    std::optional<double> distance;  ///< along x of r, metres
    double distance_sigma = 0.0;
};
/// CSV with station,angle_deg,u_deg and any of yaw_deg,u_yaw_deg (both), distance_mm,u_mm (both); u is one standard
/// deviation. Throws InputError.
[[nodiscard]] std::vector<KnownPose> read_known(const std::filesystem::path& path);

}  // namespace sc::host
