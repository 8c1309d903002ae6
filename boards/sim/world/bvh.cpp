// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/world/bvh.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <utility>

namespace sc::sim {
namespace {

constexpr std::uint32_t kLeafSize = 4;
constexpr std::uint32_t kNoTriangle = std::numeric_limits<std::uint32_t>::max();
/// Barycentric slack: neighbours overlap by a few ulp at an edge, so that no ray slips between them.
constexpr double kEdge = 1e-12;

Vec3 smaller(const Vec3& a, const Vec3& b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Vec3 larger(const Vec3& a, const Vec3& b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

double component(const Vec3& v, int axis) { return v[static_cast<std::size_t>(axis)]; }

int longest_axis(const Vec3& extent) {
    if (extent.x >= extent.y && extent.x >= extent.z) {
        return 0;
    }
    return extent.y >= extent.z ? 1 : 2;
}

/// Whether the ray meets the box before `limit`.
bool meets(const Vec3& min, const Vec3& max, const Ray& ray, const Vec3& inverse, double limit) {
    double from = 0.0;
    double to = limit;
    for (int axis = 0; axis < 3; ++axis) {
        const double origin = component(ray.origin, axis);
        const double low = component(min, axis) - origin;
        const double high = component(max, axis) - origin;
        if (component(ray.direction, axis) == 0.0) {
            // 0 · infinity is no number: a ray within the slab's planes is asked directly.
            if (low > 0.0 || high < 0.0) {
                return false;
            }
            continue;
        }
        const double a = low * component(inverse, axis);
        const double b = high * component(inverse, axis);
        from = std::max(from, std::min(a, b));
        to = std::min(to, std::max(a, b));
    }
    return from <= to;
}

}  // namespace

Bvh::Bvh(Mesh mesh) : mesh_(std::move(mesh)), order_(mesh_.triangles.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    centre_.reserve(order_.size());
    for (std::uint32_t i = 0; i < order_.size(); ++i) {
        const Box box = box_of(i);
        centre_.push_back(0.5 * (box.min + box.max));
    }
    if (!order_.empty()) {
        nodes_.reserve(order_.size());
        build(0, static_cast<std::uint32_t>(order_.size()));
    }
}

Bvh::Box Bvh::box_of(std::uint32_t triangle) const {
    const auto& t = mesh_.triangles[triangle];
    const Vec3& a = mesh_.vertices[t[0]];
    const Vec3& b = mesh_.vertices[t[1]];
    const Vec3& c = mesh_.vertices[t[2]];
    // A little larger than the triangle: a hit on its very edge must not be lost to the rounding of the box test.
    constexpr Vec3 kSlack{1e-12, 1e-12, 1e-12};
    return {smaller(smaller(a, b), c) - kSlack, larger(larger(a, b), c) + kSlack};
}

void Bvh::build(std::uint32_t first, std::uint32_t count) {
    const std::size_t self = nodes_.size();
    nodes_.emplace_back();
    Box box = box_of(order_[first]);
    Box centres{centre_[order_[first]], centre_[order_[first]]};
    for (std::uint32_t i = first + 1; i < first + count; ++i) {
        const Box other = box_of(order_[i]);
        box = {smaller(box.min, other.min), larger(box.max, other.max)};
        centres = {smaller(centres.min, centre_[order_[i]]), larger(centres.max, centre_[order_[i]])};
    }
    nodes_[self].box = box;
    if (count <= kLeafSize) {
        nodes_[self].first = first;
        nodes_[self].count = count;
        return;
    }
    const int axis = longest_axis(centres.max - centres.min);
    const std::uint32_t half = count / 2;
    const auto begin = order_.begin() + first;
    std::nth_element(begin, begin + half, begin + count, [&](std::uint32_t a, std::uint32_t b) {
        return component(centre_[a], axis) < component(centre_[b], axis);
    });
    build(first, half);
    nodes_[self].right = static_cast<std::uint32_t>(nodes_.size());
    build(first + half, count - half);
}

void Bvh::try_leaf(const Node& node, const Ray& ray, Nearest& nearest) const {
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        const auto& t = mesh_.triangles[order_[i]];
        const Vec3& a = mesh_.vertices[t[0]];
        const Vec3 ab = mesh_.vertices[t[1]] - a;
        const Vec3 ac = mesh_.vertices[t[2]] - a;
        // Moeller and Trumbore: solve origin + s · direction = a + u · ab + v · ac by Cramer's rule.
        const Vec3 p = cross(ray.direction, ac);
        const double det = dot(ab, p);
        if (det == 0.0) {
            continue;
        }
        const Vec3 from_a = ray.origin - a;
        const double u = dot(from_a, p) / det;
        const Vec3 q = cross(from_a, ab);
        const double v = dot(ray.direction, q) / det;
        const double s = dot(ac, q) / det;
        if (u >= -kEdge && v >= -kEdge && u + v <= 1.0 + kEdge && s >= 0.0 && s < nearest.t) {
            nearest = {s, order_[i]};
        }
    }
}

Hit Bvh::make_hit(const Ray& ray, const Nearest& nearest) const {
    const auto& t = mesh_.triangles[nearest.triangle];
    const Vec3& a = mesh_.vertices[t[0]];
    const Vec3 n = cross(mesh_.vertices[t[1]] - a, mesh_.vertices[t[2]] - a);
    return {ray.origin + nearest.t * ray.direction, (1.0 / norm(n)) * n, nearest.triangle};
}

std::optional<Hit> Bvh::hit(const Ray& ray) const {
    if (nodes_.empty()) {
        return std::nullopt;
    }
    const Vec3 inverse{1.0 / ray.direction.x, 1.0 / ray.direction.y, 1.0 / ray.direction.z};
    Nearest nearest{std::numeric_limits<double>::infinity(), kNoTriangle};
    // Depth is at most log2(n) + 1: the tree halves its triangles at every level.
    std::array<std::uint32_t, 64> stack{};
    std::size_t depth = 1;
    while (depth > 0) {
        const std::uint32_t index = stack[--depth];
        const Node& node = nodes_[index];
        if (!meets(node.box.min, node.box.max, ray, inverse, nearest.t)) {
            continue;
        }
        if (node.count > 0) {
            try_leaf(node, ray, nearest);
        } else {
            stack[depth++] = node.right;
            stack[depth++] = index + 1;
        }
    }
    if (nearest.triangle == kNoTriangle) {
        return std::nullopt;
    }
    return make_hit(ray, nearest);
}

}  // namespace sc::sim
