// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/peers.hpp"

#if defined(SC_WITH_CGAL)

#include <memory>
#include <thread>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>

namespace sc::host::test {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

}  // namespace

Sides make_cgal_sides(const TriangleMesh& mesh) {
    const auto surface = std::make_shared<Surface>();
    std::vector<Surface::Vertex_index> corner;
    for (const Vec3& v : mesh.vertices) {
        corner.push_back(surface->add_vertex(Kernel::Point_3(v.x, v.y, v.z)));
    }
    for (const auto& t : mesh.triangles) {
        surface->add_face(corner[t[0]], corner[t[1]], corner[t[2]]);
    }
    return [surface](const std::vector<Vec3>& places) {
        std::vector<char> inside(places.size());
        const auto work = [&](std::size_t begin, std::size_t end) {
            const CGAL::Side_of_triangle_mesh<Surface, Kernel> side(*surface);
            for (std::size_t i = begin; i < end; ++i) {
                inside[i] =
                    side(Kernel::Point_3(places[i].x, places[i].y, places[i].z)) == CGAL::ON_BOUNDED_SIDE ? 1 : 0;
            }
        };
        std::thread other(work, places.size() / 2, places.size());
        work(0, places.size() / 2);
        other.join();
        return std::vector<bool>(inside.begin(), inside.end());
    };
}

}  // namespace sc::host::test

#else

namespace sc::host::test {
Sides make_cgal_sides(const TriangleMesh&) { return {}; }
}  // namespace sc::host::test

#endif
