// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "host/formats/mesh.hpp"
#include "host/inspection/topology.hpp"

namespace sc::host {

enum class FaceKind : std::uint8_t { plane, cylinder, other };
[[nodiscard]] std::string_view name_of(FaceKind kind) noexcept;

/// A face of the CAD model, found in its triangles.
struct CadFace {
    FaceKind kind = FaceKind::other;
    Vec3 point;      ///< plane: on it; cylinder: on its axis; other: a corner. Metres
    Vec3 direction;  ///< unit; plane: outwards; cylinder: along its axis; other: mean normal
    double radius = 0.0;
    bool hollow = false;  ///< cylinder: a bore, its metal outside the radius
    double area = 0.0;    ///< square metres
    std::vector<std::uint32_t> triangles = {};
};

struct FaceMap {
    std::vector<CadFace> faces;
    std::vector<std::uint32_t> face_of;  ///< one a triangle
};

/// Cuts a mesh into planes, cylinders (patches of one axis and radius are one face) and the rest, which is cut where it
/// bends by more than 20 degrees. A mesh that names its CAD faces is cut as it says. Corners must lie on the true
/// surface to 4e-5 of the part's size (planes: 5e-6), as a tessellation's do. O(n log n).
[[nodiscard]] FaceMap segmented(const TriangleMesh& mesh, const Topology& topology);

}  // namespace sc::host
