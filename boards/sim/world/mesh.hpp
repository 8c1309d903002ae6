// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "shared/geometry/vec.hpp"

namespace sc::sim {

/// Triangles, counter-clockwise seen from outside, in metres.
struct Mesh {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Reads an ASCII OBJ file; lengths are multiplied by `unit`. Faces of more than three corners become fans; texture and
/// normal indices, groups, materials and comments are skipped. Throws WorldError for a missing file, a number that is
/// none, an index of no vertex, an unknown statement, a triangle without area, or no triangle at all.
[[nodiscard]] Mesh read_obj(const std::filesystem::path& file, double unit);

/// Adds `other` at the end of `mesh`.
void append(Mesh& mesh, const Mesh& other);

}  // namespace sc::sim
