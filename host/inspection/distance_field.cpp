// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/distance_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "host/inspection/nearest_tree.hpp"
#include "host/inspection/parallel.hpp"
#include "host/inspection/space_order.hpp"

namespace sc::host {

namespace {

/// Height over longest edge below which a triangle's normal is not trusted for a sign.
constexpr double kSliver = 1e-8;
/// Cosine of foot direction to pseudo-normal below which the sign is asked of the winding number.
constexpr double kFlat = 1e-7;

Vec3 unit(const Vec3& v) {
    const double length = norm(v);
    return length > 0.0 ? (1.0 / length) * v : Vec3{};
}

struct Nearest {
    Vec3 place;
    double squared = 0.0;
    Feature feature = Feature::face;
};

void take_segment(Nearest& best, const Vec3& p, const Vec3& a, const Vec3& b, unsigned edge) {
    const Vec3 ab = b - a;
    const double t = dot(p - a, ab) / dot(ab, ab);
    const bool start = !(t > 0.0);
    const bool end = t >= 1.0;
    const Vec3 place = start ? a : (end ? b : a + t * ab);
    const Vec3 r = p - place;
    const double squared = dot(r, r);
    if (squared < best.squared) {
        const unsigned corner = start ? edge : (edge + 1) % 3;
        const auto feature = static_cast<Feature>(start || end ? 4 + corner : 1 + edge);
        best = {place, squared, feature};
    }
}

/// The nearest place of a triangle, by the same rule as the kernels.
Nearest nearest_on(const Vec3& p, const std::array<Vec3, 3>& c) {
    Nearest best{{}, std::numeric_limits<double>::infinity(), Feature::face};
    for (unsigned k = 0; k < 3; ++k) {
        take_segment(best, p, c[k], c[(k + 1) % 3], k);
    }
    const Vec3 n = cross(c[1] - c[0], c[2] - c[1]);
    const double nn = dot(n, n);
    bool over = nn > 0.0;
    for (std::size_t k = 0; over && k < 3; ++k) {
        over = dot(cross(c[(k + 1) % 3] - c[k], p - c[k]), n) >= 0.0;
    }
    if (over) {
        const double height = dot(n, p - c[0]);
        const double squared = height * height / nn;
        if (squared < best.squared) {
            best = {p - (height / nn) * n, squared, Feature::face};
        }
    }
    return best;
}

NearestKernel kernel_of(Simd simd) {
    switch (simd) {
        case Simd::avx512: return nearest_avx512;
        case Simd::avx2: return nearest_avx2;
        case Simd::baseline: return nearest_baseline;
        case Simd::best: break;
    }
    for (const Simd choice : {Simd::avx512, Simd::avx2}) {
        if (available(choice)) {
            return kernel_of(choice);
        }
    }
    return nearest_baseline;
}

}  // namespace

std::string_view name_of(Simd simd) noexcept {
    switch (simd) {
        case Simd::best: return "best";
        case Simd::baseline: return "baseline";
        case Simd::avx2: return "avx2";
        case Simd::avx512: return "avx512";
    }
    return "?";
}

bool available(Simd simd) noexcept {
#if SC_X86_64
    if (simd == Simd::avx512) {
        return __builtin_cpu_supports("avx512f") > 0 && __builtin_cpu_supports("avx512dq") > 0 &&
               __builtin_cpu_supports("avx512vl") > 0;
    }
    if (simd == Simd::avx2) {
        return __builtin_cpu_supports("avx2") > 0 && __builtin_cpu_supports("fma") > 0;
    }
    return true;
#else
    return simd == Simd::best || simd == Simd::baseline;
#endif
}

struct DistanceField::Data {
    TriangleMesh mesh;
    Topology topology;
    NearestTree tree;
    std::vector<Vec3> corner_normal;  ///< angle-weighted, not normalised; one a vertex
    std::vector<bool> sliver;         ///< one a triangle
    std::vector<bool> doubtful;       ///< one a vertex: a sliver ends here
    Vec3 low;
    Vec3 high;
    bool turned = false;

    [[nodiscard]] std::array<Vec3, 3> corners(std::uint32_t triangle) const {
        const auto& t = mesh.triangles[triangle];
        return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
    }
    [[nodiscard]] Vec3 normal(std::uint32_t triangle) const {
        const auto c = corners(triangle);
        return unit(cross(c[1] - c[0], c[2] - c[1]));
    }

    void weigh_normals() {
        corner_normal.assign(mesh.vertices.size(), {});
        sliver.assign(mesh.triangles.size(), false);
        doubtful.assign(mesh.vertices.size(), false);
        for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
            const auto c = corners(i);
            const Vec3 n = cross(c[1] - c[0], c[2] - c[1]);
            double longest = 0.0;
            for (std::size_t k = 0; k < 3; ++k) {
                longest = std::max(longest, norm(c[(k + 1) % 3] - c[k]));
            }
            sliver[i] = norm(n) < kSliver * longest * longest;
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3 to_next = c[(k + 1) % 3] - c[k];
                const Vec3 to_last = c[(k + 2) % 3] - c[k];
                const double angle = std::atan2(norm(cross(to_next, to_last)), dot(to_next, to_last));
                const std::uint32_t corner = mesh.triangles[i][k];
                corner_normal[corner] = corner_normal[corner] + angle * unit(n);
                if (sliver[i]) {
                    doubtful[corner] = true;
                }
            }
        }
    }

    /// Normal that tells the side at a feature; zero where it cannot be trusted.
    [[nodiscard]] Vec3 side_normal(std::uint32_t triangle, Feature feature) const {
        const auto kind = static_cast<unsigned>(feature);
        if (kind >= 4) {
            const std::uint32_t corner = mesh.triangles[triangle][kind - 4];
            return doubtful[corner] ? Vec3{} : unit(corner_normal[corner]);
        }
        if (sliver[triangle]) {
            return {};
        }
        if (kind == 0) {
            return normal(triangle);
        }
        const std::uint32_t other = topology.neighbour[triangle][kind - 1];
        if (other == kNoTriangle) {
            return normal(triangle);
        }
        return sliver[other] ? Vec3{} : unit(normal(triangle) + normal(other));
    }

    /// Whether the mesh winds about a place: the sum of the solid angles of all triangles (Van Oosterom, Strackee
    /// 1983).
    [[nodiscard]] bool wound_about(const Vec3& p) const {
        double sum = 0.0;
        for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
            const auto c = corners(i);
            const Vec3 a = c[0] - p;
            const Vec3 b = c[1] - p;
            const Vec3 d = c[2] - p;
            const double la = norm(a);
            const double lb = norm(b);
            const double ld = norm(d);
            sum +=
                2.0 * std::atan2(dot(a, cross(b, d)), la * lb * ld + dot(a, b) * ld + dot(b, d) * la + dot(d, a) * lb);
        }
        return sum > 6.283185307179586;  // half of the full 4π
    }

    /// From the leaf that the kernel found, which is in the cache still; `local` is relative to the tree's centre.
    [[nodiscard]] Distance finished(const Vec3& local, std::uint32_t slot) const {
        const TreeLeaf& leaf = tree.leaves[slot / 8];
        const std::size_t lane = slot % 8;
        const std::uint32_t triangle = leaf.triangle[lane];
        std::array<Vec3, 3> c;
        for (std::size_t k = 0; k < 3; ++k) {
            c[k] = {leaf.corner[k][0][lane], leaf.corner[k][1][lane], leaf.corner[k][2][lane]};
        }
        const Nearest nearest = nearest_on(local, c);
        const Vec3 r = local - nearest.place;
        const double length = std::sqrt(nearest.squared);
        if (nearest.feature == Feature::face && !sliver[triangle]) {
            const bool under = dot(cross(c[1] - c[0], c[2] - c[1]), local - c[0]) < 0.0;
            return {under ? -length : length, triangle, nearest.feature};
        }
        const Vec3 side = side_normal(triangle, nearest.feature);
        const double cosine = dot(side, r);
        bool inside = cosine < 0.0;
        if (std::abs(cosine) <= kFlat * length && length > 0.0 && topology.closed()) {
            inside = wound_about(local + tree.centre);
        }
        return {inside ? -length : length, triangle, nearest.feature};
    }
};

DistanceField::DistanceField(TriangleMesh mesh) : data_(std::make_unique<Data>()) {
    Data& d = *data_;
    d.mesh = std::move(mesh);
    d.topology = topology_of(d.mesh);
    if (d.topology.closed() && d.topology.volume < 0.0) {
        turn_over(d.mesh);
        d.topology = topology_of(d.mesh);
        d.turned = true;
    }
    d.tree = build_nearest_tree(d.mesh);
    d.tree.leaves.shrink_to_fit();
    d.tree.nodes.shrink_to_fit();
    d.weigh_normals();
    d.low = d.high = d.mesh.vertices.empty() ? Vec3{} : d.mesh.vertices.front();
    for (const Vec3& v : d.mesh.vertices) {
        d.low = {std::min(d.low.x, v.x), std::min(d.low.y, v.y), std::min(d.low.z, v.z)};
        d.high = {std::max(d.high.x, v.x), std::max(d.high.y, v.y), std::max(d.high.z, v.z)};
    }
}

DistanceField::~DistanceField() = default;
DistanceField::DistanceField(DistanceField&&) noexcept = default;
DistanceField& DistanceField::operator=(DistanceField&&) noexcept = default;

Distance DistanceField::at(const Vec3& place) const {
    Distance out;
    measure({&place, 1}, {&out, 1}, {.threads = 1, .simd = Simd::best, .sorted = true});
    return out;
}

void DistanceField::measure(std::span<const Vec3> places, std::span<Distance> out,
                            const DistanceOptions& options) const {
    const Data& d = *data_;
    const NearestKernel kernel = kernel_of(options.simd);
    const unsigned threads = thread_count(options.threads);
    constexpr std::size_t kBatch = 256;  // stays in the first cache
    constexpr std::size_t kPiece = 32 * kBatch;
    constexpr std::size_t kAhead = 24;
    const std::vector<std::uint32_t> order =
        options.sorted || places.size() < 64 ? std::vector<std::uint32_t>{} : space_order(places, threads);
    parallel_pieces(places.size(), kPiece, threads, [&](std::size_t begin, std::size_t end, unsigned) {
        std::array<Vec3, kBatch> local;
        std::array<NearestSlot, kBatch> slots;
        std::uint32_t seed = 0;
        const auto index = [&order](std::size_t i) { return order.empty() ? i : std::size_t{order[i]}; };
        for (std::size_t at = begin; at < end; at += kBatch) {
            const std::size_t count = std::min(kBatch, end - at);
            for (std::size_t i = 0; i < count; ++i) {
                // The places lie anywhere in memory: fetch what comes soon, and where its answer goes.
                const std::size_t ahead = index(std::min(at + i + kAhead, places.size() - 1));
                __builtin_prefetch(&places[ahead]);
                __builtin_prefetch(&out[ahead], 1);
                local[i] = places[index(at + i)] - d.tree.centre;
            }
            kernel(d.tree, {local.data(), count}, {slots.data(), count}, seed);
            for (std::size_t i = 0; i < count; ++i) {
                out[index(at + i)] = d.finished(local[i], slots[i].slot);
            }
        }
    });
}

Foot DistanceField::foot(const Vec3& place, const Distance& distance) const {
    const Nearest nearest = nearest_on(place, data_->corners(distance.triangle));
    const Vec3 r = place - nearest.place;
    // Very near the surface the difference has no digits; the normal has.
    if (std::abs(distance.value) < 1e-9 || nearest.feature == Feature::face) {
        const Vec3 side = data_->side_normal(distance.triangle, nearest.feature);
        if (dot(side, side) > 0.0) {
            return {nearest.place, side};
        }
    }
    return {nearest.place, (distance.value < 0.0 ? -1.0 : 1.0) * unit(r)};
}

Vec3 DistanceField::growth(const Vec3& place, const Distance& distance) const {
    return distance.feature == Feature::face && !data_->sliver[distance.triangle] ? data_->normal(distance.triangle)
                                                                                  : foot(place, distance).direction;
}

const TriangleMesh& DistanceField::mesh() const noexcept { return data_->mesh; }
const Topology& DistanceField::topology() const noexcept { return data_->topology; }
bool DistanceField::turned() const noexcept { return data_->turned; }
Vec3 DistanceField::normal(std::uint32_t triangle) const { return data_->normal(triangle); }
Vec3 DistanceField::low() const noexcept { return data_->low; }
Vec3 DistanceField::high() const noexcept { return data_->high; }
double DistanceField::diagonal() const noexcept { return norm(data_->high - data_->low); }

std::size_t DistanceField::bytes() const noexcept {
    const Data& d = *data_;
    return d.mesh.vertices.capacity() * sizeof(Vec3) + d.mesh.triangles.capacity() * 12 +
           d.topology.neighbour.capacity() * 12 + d.tree.nodes.capacity() * sizeof(TreeNode) +
           d.tree.leaves.capacity() * sizeof(TreeLeaf) + d.corner_normal.capacity() * sizeof(Vec3) +
           d.mesh.triangles.size() / 8 + d.mesh.vertices.size() / 8;
}

}  // namespace sc::host
