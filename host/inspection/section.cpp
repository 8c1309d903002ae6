// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/section.hpp"

#include <array>

namespace sc::host {

std::vector<SectionPiece> section(const TriangleMesh& mesh, const Plane& plane) {
    std::vector<double> height;
    height.reserve(mesh.vertices.size());
    for (const Vec3& v : mesh.vertices) {
        height.push_back(plane.height(v));
    }
    std::vector<SectionPiece> out;
    for (const auto& t : mesh.triangles) {
        std::array<Vec3, 2> ends{};  // on the edge that goes down through the plane, on the one that comes up
        bool crossed = false;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k];
            const std::uint32_t b = t[(k + 1) % 3];
            if ((height[a] >= 0.0) == (height[b] >= 0.0)) {
                continue;
            }
            crossed = true;
            // From the lower-numbered corner, so that both triangles at an edge give the same place.
            const std::uint32_t low = a < b ? a : b;
            const std::uint32_t high = a < b ? b : a;
            const double share = height[low] / (height[low] - height[high]);
            ends[height[a] >= 0.0 ? 0 : 1] = mesh.vertices[low] + share * (mesh.vertices[high] - mesh.vertices[low]);
        }
        if (crossed) {
            out.push_back({ends[0], ends[1]});
        }
    }
    return out;
}

double length_of(std::span<const SectionPiece> pieces) noexcept {
    double sum = 0.0;
    for (const SectionPiece& piece : pieces) {
        sum += norm(piece.to - piece.from);
    }
    return sum;
}

}  // namespace sc::host
