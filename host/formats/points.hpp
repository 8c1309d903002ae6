// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "shared/geometry/vec.hpp"

namespace sc::host {

/// One point of a face. Its frame is that of the job's face, so it carries none itself.
struct FacePoint {
    int line = 0;  ///< in the source file
    int no = 0;
    Vec3 place;  ///< metres
};
struct FacePoints {
    std::filesystem::path file;
    std::vector<FacePoint> points;  ///< in the order of the file
};

/// Reads a CSV with the columns no,x,y,z (millimetres). Throws InputError for all that CsvTable refuses, unknown
/// columns, a number that appears twice, and no rows. The unit cannot be judged without the frame: use guess_unit
/// (unit_guess.hpp) once the places can be converted.
[[nodiscard]] FacePoints read_points(const std::filesystem::path& path);
/// A place of a free path.
struct RoutePoint {
    int line = 0;
    Vec3 place;  ///< metres
};
/// Reads a CSV with the columns x,y,z (millimetres), in the order of its rows. Throws InputError as read_points, and
/// for fewer than two rows.
[[nodiscard]] std::vector<RoutePoint> read_route(const std::filesystem::path& path);
/// Writes the columns no,x,y,z with 0.1 µm. Throws InputError if it cannot be written.
void write_points(const std::filesystem::path& path, const FacePoints& points);

}  // namespace sc::host
