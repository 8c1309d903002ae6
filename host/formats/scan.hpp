// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "host/formats/length_unit.hpp"
#include "shared/geometry/vec.hpp"

namespace sc::host {

/// A measured cloud. Lengths in metres, in the frame of the file.
struct PointCloud {
    std::vector<Vec3> points;
    std::vector<std::uint32_t> view;  ///< from which a point was seen; empty where the file does not say
};

struct ScanFile {
    PointCloud cloud;
    LengthUnit unit;
    std::size_t read = 0;        ///< points in the file
    std::size_t not_finite = 0;  ///< of them, left out: NaN or infinite, as organised clouds mark what was not seen
};

/// Reads a cloud: PLY (ASCII, both byte orders), PCD (ascii, binary, binary_compressed), XYZ, ASC, TXT, CSV (blanks,
/// commas or semicolons; `#` or `//` starts a comment; one line of column names may stand first), or the corners of an
/// STL. `unit` is that of the file's numbers. Throws InputError (file, line or byte, value, what to do) for all it
/// cannot understand, for no point, and for no finite point. Some 60 MB/s of text, binary at the disk's speed.
[[nodiscard]] ScanFile read_scan(const std::filesystem::path& path, const LengthUnit& unit = {});

/// Writes a binary PLY in millimetres, f32, with the views if there are any.
void write_ply(const std::filesystem::path& path, const PointCloud& cloud);

}  // namespace sc::host
