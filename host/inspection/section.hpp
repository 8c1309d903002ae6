// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "host/formats/mesh.hpp"

namespace sc::host {

struct Plane {
    Vec3 point;   ///< metres
    Vec3 normal;  ///< unit
    [[nodiscard]] double height(const Vec3& place) const noexcept { return dot(place - point, normal); }
};

/// A straight piece of a section; seen against the normal of the plane the metal lies on its left.
struct SectionPiece {
    Vec3 from;
    Vec3 to;
};

/// Where a plane cuts a mesh: one piece a triangle that it crosses, in the order of the triangles. A corner on the
/// plane counts as above it, so a closed mesh gives closed loops. O(n).
[[nodiscard]] std::vector<SectionPiece> section(const TriangleMesh& mesh, const Plane& plane);
[[nodiscard]] double length_of(std::span<const SectionPiece> pieces) noexcept;

}  // namespace sc::host
