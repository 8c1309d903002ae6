// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "host/formats/mesh.hpp"

/// What the benchmark of the distance engine works on.

namespace sc::host::test {

/// The same surface with more triangles: the longest edge is halved, over and over, until there are `triangles`.
[[nodiscard]] TriangleMesh split_to(TriangleMesh mesh, std::size_t triangles);
/// All lengths times `factor`.
[[nodiscard]] TriangleMesh scaled(TriangleMesh mesh, double factor);
/// Places spread evenly over the surface, `least` to `most` metres along the normal, plus white noise, in random order.
[[nodiscard]] std::vector<Vec3> places_off(const TriangleMesh& mesh, std::size_t count, double least, double most,
                                           double noise, std::uint64_t seed);
/// Places within `reach` of edges and corners.
[[nodiscard]] std::vector<Vec3> places_at_edges(const TriangleMesh& mesh, std::size_t count, double reach,
                                                std::uint64_t seed);
/// Unsigned distance by looking at every triangle (those whose ball is too far away are not looked at closely), by
/// Ericson's regions: none of the engine's code.
[[nodiscard]] std::vector<double> brute_distances(const TriangleMesh& mesh, const std::vector<Vec3>& places);

}  // namespace sc::host::test
