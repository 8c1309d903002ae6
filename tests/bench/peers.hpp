// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "host/formats/mesh.hpp"

/// Other people's engines, behind one face. Each returns an empty function where the library was not there at build
/// time.

namespace sc::host::test {

/// Signed distances, one thread: Embree's point query with a triangle test and a sign in double precision.
using Distances = std::function<void(const std::vector<Vec3>& places, std::vector<double>& out)>;
[[nodiscard]] Distances make_embree(const TriangleMesh& mesh);

/// Whether places are inside, by CGAL's Side_of_triangle_mesh, all cores.
using Sides = std::function<std::vector<bool>(const std::vector<Vec3>& places)>;
[[nodiscard]] Sides make_cgal_sides(const TriangleMesh& mesh);

}  // namespace sc::host::test
