// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "shared/geometry/vec.hpp"

namespace sc::host {

/// A polyline in space, for a drawing.
struct DxfLine {
    std::string layer;         ///< letters, digits, `-` and `_`; others become `_`
    std::vector<Vec3> places;  ///< metres
    bool closed = false;
};

/// Writes a DXF (release 12, ASCII) of 3-D polylines in millimetres with 0.1 µm; one layer a name. Throws InputError if
/// it cannot be written.
void write_dxf(const std::filesystem::path& path, const std::vector<DxfLine>& lines);

}  // namespace sc::host
