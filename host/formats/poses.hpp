// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/geometry/vec.hpp"

/// Poses and marker clouds as robots, trackers and 3-D sensors write them: CSV (docs/formats.md). The convention of the
/// rotation follows from the names of the columns, the unit from their suffix. In memory all is metres and radians.

namespace sc::host {

/// How a file writes a rotation.
enum class PoseConvention : std::uint8_t {
    quaternion,  ///< qw,qx,qy,qz in any order: Hamilton's, qw the real part
    abb,         ///< q1,q2,q3,q4: q1 the real part
    matrix,      ///< r11 to r33, rows first
    kuka,        ///< a,b,c, degrees: Rz(a)·Ry(b)·Rx(c)
    fanuc,       ///< w,p,r, degrees: Rz(r)·Ry(p)·Rx(w)
};
[[nodiscard]] std::string_view name_of(PoseConvention convention) noexcept;

/// Rotation matrix of a quaternion (real part first); it is normalised. Its norm must not be 0.
[[nodiscard]] Mat3 rotation_of_quaternion(const std::array<double, 4>& wxyz) noexcept;
/// Rz(z)·Ry(y)·Rx(x), radians.
[[nodiscard]] Mat3 rotation_of_zyx(double z, double y, double x) noexcept;

struct NamedPose {
    int line = 0;                ///< of the file
    std::string view;            ///< what pairs it with other files; unique
    std::optional<double> time;  ///< seconds, where the file has time_s in place of a view
    std::optional<double> turn;  ///< radians: reading of a turntable
    std::optional<double> tilt;  ///< radians: reading of an axis below the turntable
    Mat3 rotation;
    Vec3 translation;  ///< metres
};
struct PoseFile {
    std::filesystem::path file;
    PoseConvention convention = PoseConvention::quaternion;
    std::vector<NamedPose> poses;
};

/// A marker as one view saw it.
struct SeenMarker {
    int line = 0;
    int id = 0;  ///< unique in a view
    Vec3 place;  ///< metres
    Vec3 sigma;  ///< metres, along x, y, z; all 0: not stated
};
struct MarkerView {
    int line = 0;
    std::string view;
    std::optional<double> time;
    std::optional<double> turn;  ///< radians
    std::vector<SeenMarker> markers;
};
struct MarkerFile {
    std::filesystem::path file;
    std::vector<MarkerView> views;  ///< in the order of the file
};

/// What a file does not say itself.
struct PoseFileWords {
    std::string columns;  ///< header of a file that has none, with commas; empty: the first line is the header
    std::string unit;     ///< of x,y,z without a suffix: "mm", "m", "inch"...; empty: such columns are refused
};

/// Both throw InputError (file, line, value, what to do) for all that CsvTable refuses, an unknown column, two
/// conventions in one file, units that are missing or mixed, a quaternion or matrix that is no rotation, a left-handed
/// matrix, a place further than 100 m away, a view or a marker of a view that appears twice.
[[nodiscard]] PoseFile read_poses(const std::filesystem::path& path, const PoseFileWords& words = {});
[[nodiscard]] MarkerFile read_marker_views(const std::filesystem::path& path, const PoseFileWords& words = {});
/// Whether the file has a column "id": markers; else poses. Throws as CsvTable does.
[[nodiscard]] bool holds_markers(const std::filesystem::path& path, const PoseFileWords& words = {});

}  // namespace sc::host
