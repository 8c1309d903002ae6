// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "host/formats/mesh.hpp"

namespace sc::host {

/// Which triangle lies across an edge. Edge k of a triangle runs from its corner k to the next.
inline constexpr std::uint32_t kNoTriangle = std::numeric_limits<std::uint32_t>::max();

/// An edge that keeps a surface from being closed.
struct BadEdge {
    Vec3 from;  ///< metres
    Vec3 to;
    std::size_t triangles =
        0;  ///< that meet here: 1 = open, more than 2 = not a surface, 2 = turned against each other
};

/// How the triangles of a mesh hang together.
struct Topology {
    std::vector<std::array<std::uint32_t, 3>> neighbour;  ///< kNoTriangle where there is not exactly one
    std::size_t open_edges = 0;                           ///< with one triangle
    std::size_t crowded_edges = 0;                        ///< with more than two
    std::size_t turned_edges = 0;                         ///< whose two triangles disagree on which side is out
    std::vector<BadEdge> examples;                        ///< up to five of all these
    std::size_t shells = 0;                               ///< connected pieces
    double volume = 0.0;                                  ///< cubic metres; negative = triangles face inwards

    [[nodiscard]] bool closed() const noexcept { return open_edges + crowded_edges + turned_edges == 0; }
};

/// O(triangles). The mesh must be welded.
[[nodiscard]] Topology topology_of(const TriangleMesh& mesh);
/// One line for a person: how many edges of each kind, and where the first ones are, in mm.
[[nodiscard]] std::string open_text(const Topology& topology);
/// Turns all triangles over.
void turn_over(TriangleMesh& mesh) noexcept;

}  // namespace sc::host
