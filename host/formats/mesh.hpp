// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "host/formats/length_unit.hpp"
#include "shared/geometry/vec.hpp"

namespace sc::host {

/// Triangles that share their corners, counter-clockwise seen from outside. Lengths in metres.
struct TriangleMesh {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint32_t> face;  ///< of the CAD model, one a triangle; empty where the file has none
};

struct MeshFile {
    TriangleMesh mesh;
    LengthUnit unit;
    std::size_t read = 0;     ///< triangles in the file (polygons are cut into triangles)
    std::size_t dropped = 0;  ///< of them, without area because two corners are the same place
};

/// Reads STL (ASCII, binary), PLY (ASCII, both byte orders) or OBJ, told apart by content, then by name. Corners at
/// exactly the same place become one. `unit` is that of the file's numbers. Throws InputError (file, line or byte,
/// value, what to do) for all it cannot understand, no triangle, and numbers that are not finite.
[[nodiscard]] MeshFile read_mesh(const std::filesystem::path& path, const LengthUnit& unit = {});

/// Writes a binary STL in millimetres (f32 as the format has it). Throws InputError if it cannot be written.
void write_stl(const std::filesystem::path& path, const TriangleMesh& mesh);

/// Joins corners at exactly the same place, in the order of their first use, and drops triangles that lose one.
/// `corners`: three a triangle.
[[nodiscard]] TriangleMesh welded(std::span<const Vec3> corners);

}  // namespace sc::host
