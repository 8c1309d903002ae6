// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <vector>

#include "host/formats/mesh.hpp"

/// Meshes whose distances are known in closed form.

namespace sc::host::test {

inline std::filesystem::path casting(const char* name) {
    return std::filesystem::path(SC_TEST_DATA) / "casting-blank" / name;
}

/// An upright box from `low` to `high`.
inline TriangleMesh box_mesh(const Vec3& low, const Vec3& high) {
    TriangleMesh mesh;
    for (unsigned i = 0; i < 8; ++i) {
        mesh.vertices.push_back(
            {(i & 1U) != 0 ? high.x : low.x, (i & 2U) != 0 ? high.y : low.y, (i & 4U) != 0 ? high.z : low.z});
    }
    constexpr std::array<std::array<std::uint32_t, 4>, 6> kSides{
        {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
    for (const auto& q : kSides) {
        mesh.triangles.push_back({q[0], q[1], q[2]});
        mesh.triangles.push_back({q[0], q[2], q[3]});
    }
    return mesh;
}

/// A block of `size` by `size` by `height` with a bore through its middle along z; `facets` around. The z faces and the
/// bore are the ones to machine.
inline TriangleMesh bored_block(double size, double height, double radius, unsigned facets) {
    TriangleMesh mesh;
    const auto around = [&](double r, bool square, double z) {
        for (unsigned i = 0; i < facets; ++i) {
            const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(facets);
            const double c = std::cos(angle);
            const double s = std::sin(angle);
            const double scale = square ? 0.5 * size / std::max(std::abs(c), std::abs(s)) : r;
            mesh.vertices.push_back({scale * c, scale * s, z});
        }
    };
    around(radius, false, 0.0);
    around(0.0, true, 0.0);
    around(radius, false, height);
    around(0.0, true, height);
    const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
    };
    const std::uint32_t n = facets;
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t j = (i + 1) % n;
        quad(i, n + i, n + j, j);  // bottom
        std::swap(mesh.triangles[mesh.triangles.size() - 2][1], mesh.triangles[mesh.triangles.size() - 2][2]);
        std::swap(mesh.triangles.back()[1], mesh.triangles.back()[2]);
        quad(2 * n + i, 3 * n + i, 3 * n + j, 2 * n + j);  // top
        quad(i, 2 * n + i, 2 * n + j, j);                  // bore
        std::swap(mesh.triangles[mesh.triangles.size() - 2][1], mesh.triangles[mesh.triangles.size() - 2][2]);
        std::swap(mesh.triangles.back()[1], mesh.triangles.back()[2]);
        std::swap(mesh.triangles[mesh.triangles.size() - 2][1], mesh.triangles[mesh.triangles.size() - 2][2]);
        std::swap(mesh.triangles.back()[1], mesh.triangles.back()[2]);
        quad(n + i, 3 * n + i, 3 * n + j, n + j);  // outside
        std::swap(mesh.triangles[mesh.triangles.size() - 2][1], mesh.triangles[mesh.triangles.size() - 2][2]);
        std::swap(mesh.triangles.back()[1], mesh.triangles.back()[2]);
    }
    return mesh;
}

}  // namespace sc::host::test
