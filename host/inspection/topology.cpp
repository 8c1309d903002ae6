// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/topology.hpp"

#include <algorithm>
#include <utility>

#include "host/formats/text.hpp"

namespace sc::host {

namespace {

/// A triangle's edge, filed under its lower corner.
struct HalfEdge {
    std::uint32_t other = 0;  ///< the higher corner
    std::uint32_t triangle = 0;
    std::uint8_t edge = 0;
    bool upwards = false;  ///< runs from the lower corner to the higher
};

std::vector<std::uint32_t> starts_by_lower_corner(const TriangleMesh& mesh) {
    std::vector<std::uint32_t> start(mesh.vertices.size() + 1, 0);
    for (const auto& t : mesh.triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            ++start[std::min(t[k], t[(k + 1) % 3]) + 1];
        }
    }
    for (std::size_t i = 1; i < start.size(); ++i) {
        start[i] += start[i - 1];
    }
    return start;
}

std::vector<HalfEdge> filed(const TriangleMesh& mesh, std::vector<std::uint32_t> next) {
    std::vector<HalfEdge> edges(3 * mesh.triangles.size());
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        const auto& t = mesh.triangles[i];
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = t[k];
            const std::uint32_t to = t[(k + 1) % 3];
            edges[next[std::min(from, to)]++] = {std::max(from, to), i, static_cast<std::uint8_t>(k), from < to};
        }
    }
    return edges;
}

class Pieces {
public:
    explicit Pieces(std::size_t count) : parent_(count) {
        for (std::uint32_t i = 0; i < count; ++i) {
            parent_[i] = i;
        }
    }
    std::uint32_t root(std::uint32_t i) {
        while (parent_[i] != i) {
            parent_[i] = parent_[parent_[i]];
            i = parent_[i];
        }
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b) { parent_[root(a)] = root(b); }
    [[nodiscard]] std::size_t count() const {
        std::size_t out = 0;
        for (std::uint32_t i = 0; i < parent_.size(); ++i) {
            out += parent_[i] == i ? 1U : 0U;
        }
        return out;
    }

private:
    std::vector<std::uint32_t> parent_;
};

}  // namespace

Topology topology_of(const TriangleMesh& mesh) {
    Topology out;
    out.neighbour.assign(mesh.triangles.size(), {kNoTriangle, kNoTriangle, kNoTriangle});
    const std::vector<std::uint32_t> start = starts_by_lower_corner(mesh);
    std::vector<HalfEdge> edges = filed(mesh, start);
    Pieces pieces(mesh.triangles.size());
    for (std::uint32_t corner = 0; corner < mesh.vertices.size(); ++corner) {
        const auto begin = edges.begin() + start[corner];
        const auto end = edges.begin() + start[corner + 1];
        std::sort(begin, end, [](const HalfEdge& a, const HalfEdge& b) { return a.other < b.other; });
        for (auto first = begin; first != end;) {
            auto last = first;
            while (last != end && last->other == first->other) {
                pieces.join(first->triangle, last->triangle);
                ++last;
            }
            const auto count = static_cast<std::size_t>(last - first);
            if (count == 2 && first->upwards != (first + 1)->upwards) {
                out.neighbour[first->triangle][first->edge] = (first + 1)->triangle;
                out.neighbour[(first + 1)->triangle][(first + 1)->edge] = first->triangle;
            } else {
                ++(count == 1 ? out.open_edges : (count == 2 ? out.turned_edges : out.crowded_edges));
                if (out.examples.size() < 5) {
                    out.examples.push_back({mesh.vertices[corner], mesh.vertices[first->other], count});
                }
            }
            first = last;
        }
    }
    out.shells = pieces.count();
    // About a corner of the mesh, so that a part far from the origin loses no digits.
    const Vec3 origin = mesh.vertices.empty() ? Vec3{} : mesh.vertices.front();
    for (const auto& t : mesh.triangles) {
        out.volume +=
            dot(mesh.vertices[t[0]] - origin, cross(mesh.vertices[t[1]] - origin, mesh.vertices[t[2]] - origin)) / 6.0;
    }
    return out;
}

std::string open_text(const Topology& topology) {
    std::string out = std::to_string(topology.open_edges) + " open edges, " + std::to_string(topology.crowded_edges) +
                      " edges of more than two triangles, " + std::to_string(topology.turned_edges) +
                      " between triangles that face opposite ways";
    for (const BadEdge& edge : topology.examples) {
        out += (&edge == &topology.examples.front() ? "; the first: (" : ", (") + fixed(1e3 * edge.from.x, 3) + " " +
               fixed(1e3 * edge.from.y, 3) + " " + fixed(1e3 * edge.from.z, 3) + ")-(" + fixed(1e3 * edge.to.x, 3) +
               " " + fixed(1e3 * edge.to.y, 3) + " " + fixed(1e3 * edge.to.z, 3) + ") mm";
    }
    return out;
}

void turn_over(TriangleMesh& mesh) noexcept {
    for (auto& t : mesh.triangles) {
        std::swap(t[1], t[2]);
    }
}

}  // namespace sc::host
