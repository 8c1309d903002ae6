// SPDX-License-Identifier: Apache-2.0
// The walk through the tree, compiled once an instruction set: each nearest_*.cpp defines SC_KERNEL (its namespace) and
// SC_LANES (doubles in a register) and includes this. Nothing here may be shared between them.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include "host/inspection/nearest_tree.hpp"

namespace sc::host::SC_KERNEL {
namespace {

using Doubles = double __attribute__((vector_size(8 * SC_LANES)));
using Floats = float __attribute__((vector_size(32)));

struct V {
    Doubles x, y, z;
};

inline V operator-(const V& a, const V& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Doubles dot(const V& a, const V& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline V cross(const V& a, const V& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

inline Doubles load(const double* at) {
    Doubles out;
    __builtin_memcpy(&out, at, sizeof(out));
    return out;
}
inline Floats load(const float* at) {
    Floats out;
    __builtin_memcpy(&out, at, sizeof(out));
    return out;
}
inline V load_corner(const TreeLeaf& leaf, std::size_t corner, std::size_t lane) {
    const auto& c = leaf.corner[corner];
    return {load(&c[0][lane]), load(&c[1][lane]), load(&c[2][lane])};
}

/// Lanes in which `value` is below `limit`.
inline unsigned below(const Floats& value, float limit) {
#if defined(__AVX512VL__)
    return _mm256_cmp_ps_mask(value, _mm256_set1_ps(limit), _CMP_LT_OQ);
#elif defined(__AVX2__)
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(value, _mm256_set1_ps(limit), _CMP_LT_OQ)));
#else
    unsigned out = 0;
    for (unsigned i = 0; i < 8; ++i) {
        out |= value[i] < limit ? 1U << i : 0U;
    }
    return out;
#endif
}
inline unsigned below(const Doubles& value, double limit) {
#if defined(__AVX512F__)
    return _mm512_cmp_pd_mask(value, _mm512_set1_pd(limit), _CMP_LT_OQ);
#elif defined(__AVX2__)
    return static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(value, _mm256_set1_pd(limit), _CMP_LT_OQ)));
#else
    unsigned out = 0;
    for (unsigned i = 0; i < SC_LANES; ++i) {
        out |= value[i] < limit ? 1U << i : 0U;
    }
    return out;
#endif
}

/// Squared distance to a segment; `ap` from its start to the place.
inline Doubles to_segment(const V& ap, const V& ab) {
    Doubles t = dot(ap, ab) / dot(ab, ab);
    t = t > 0.0 ? t : Doubles{};
    t = t < 1.0 ? t : Doubles{} + 1.0;
    const V r{ap.x - t * ab.x, ap.y - t * ab.y, ap.z - t * ab.z};
    return dot(r, r);
}

/// Squared distances of places to triangles, lane by lane. The plane counts where the place is over the triangle, else
/// the nearest edge: of a needle, whose normal has few digits, the edges still have all of theirs.
inline Doubles to_triangles(const V& a, const V& b, const V& c, const V& p) {
    const V ab = b - a;
    const V bc = c - b;
    const V ca = a - c;
    const V ap = p - a;
    const V bp = p - b;
    const V cp = p - c;
    const V n = cross(ab, bc);
    const Doubles height = dot(n, ap);
    const Doubles on_plane = height * height / dot(n, n);
    Doubles out = to_segment(ap, ab);
    const Doubles second = to_segment(bp, bc);
    const Doubles third = to_segment(cp, ca);
    out = second < out ? second : out;
    out = third < out ? third : out;
    const Doubles inside_ab = dot(cross(ab, ap), n);
    const Doubles inside_bc = dot(cross(bc, bp), n);
    const Doubles inside_ca = dot(cross(ca, cp), n);
    Doubles inside = inside_ab < inside_bc ? inside_ab : inside_bc;
    inside = inside < inside_ca ? inside : inside_ca;
    const Doubles over = inside >= 0.0 ? on_plane : Doubles{} + std::numeric_limits<double>::infinity();
    return over < out ? over : out;  // no number where the triangle has no area: then the edges
}

struct Boxes {
    Floats low[3];
    Floats high[3];
};

/// Squared distances of eight boxes to a box; `low` == `high` for a place.
inline Floats to_boxes(const Boxes& boxes, const Floats low[3], const Floats high[3]) {
    Floats out{};
    for (int axis = 0; axis < 3; ++axis) {
        const Floats under = boxes.low[axis] - high[axis];
        const Floats over = low[axis] - boxes.high[axis];
        const Floats beyond = under > over ? under : over;
        const Floats d = beyond > 0.0F ? beyond : Floats{};
        out += d * d;
    }
    return out;
}
inline Boxes load_boxes(const TreeNode& node) {
    return {{load(node.low[0].data()), load(node.low[1].data()), load(node.low[2].data())},
            {load(node.high[0].data()), load(node.high[1].data()), load(node.high[2].data())}};
}

/// A little more than a squared distance, for what single precision loses on boxes; never nothing.
inline float widened(double squared) {
    return static_cast<float>(squared) * 1.000002F + std::numeric_limits<float>::min();
}

constexpr std::size_t kGroup = 16;   ///< places that share a walk at most
constexpr std::size_t kListed = 64;  ///< pieces that a shared walk may find
constexpr std::uint32_t kNone = 0xffffffffU;
constexpr std::size_t kPieceLanes = SC_LANES > 4 ? 8 : 4;  ///< triangles of a listed piece

/// Walks the tree, for one place or for several that are close together.
class Walk {
public:
    explicit Walk(const NearestTree& tree) : nodes_(tree.nodes.data()), leaves_(tree.leaves.data()) {}

    NearestSlot nearest(const Vec3& place, std::uint32_t seed) {
        start(place, {std::numeric_limits<double>::infinity(), seed});
        const std::uint32_t seed_leaf = seed / 8;
        test_leaf(seed_leaf);
        std::size_t depth = 0;
        std::uint32_t at = 0;
        while (true) {
            const Floats squared = to_boxes(load_boxes(nodes_[at]), low_, low_);
            unsigned hits = below(squared, limit_);
            std::uint32_t next = kNone;
            float nearest = std::numeric_limits<float>::infinity();
            while (hits != 0) {
                const auto lane = static_cast<unsigned>(__builtin_ctz(hits));
                hits &= hits - 1;
                const std::uint32_t child = nodes_[at].child[lane];
                const float distance = squared[lane];
                if (distance < nearest) {
                    if (next != kNone) {
                        stack_[depth++] = {nearest, next};
                    }
                    nearest = distance;
                    next = child;
                } else {
                    stack_[depth++] = {distance, child};
                }
            }
            while (true) {
                if (next == kNone) {
                    if (depth == 0) {
                        return best_;
                    }
                    --depth;
                    nearest = stack_[depth].distance;
                    next = stack_[depth].child;
                }
                if (nearest < limit_) {
                    if ((next & kLeafBit) == 0) {
                        break;
                    }
                    if ((next & ~kLeafBit) != seed_leaf) {
                        test_leaf(next & ~kLeafBit);
                    }
                }
                next = kNone;
            }
            at = next;
        }
    }

    /// All places of a group in one walk; false if it meets too many leaves. `seed` as for one place.
    bool nearest_of_group(const Vec3* places, std::size_t count, NearestSlot* out, std::uint32_t& seed) {
        out[0] = nearest(places[0], seed);
        seed = out[0].slot;
        const double reach = guess(places, count, out);
        if (!list_pieces(places, count, widened(reach))) {
            return false;
        }
        for (std::size_t i = 1; i < count; ++i) {
            start(places[i], out[i]);
            limit_ = widened(best_.squared);
            for (std::size_t at = 0; at < listed_; at += 8) {
                Boxes boxes;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    boxes.low[axis] = load(&piece_low_[axis][at]);
                    boxes.high[axis] = load(&piece_high_[axis][at]);
                }
                const Floats squared = to_boxes(boxes, low_, low_);
                unsigned hits = below(squared, limit_);
                while (hits != 0) {
                    const auto lane = static_cast<unsigned>(__builtin_ctz(hits));
                    hits &= hits - 1;
                    if (squared[lane] < limit_) {
                        test_piece(piece_[at + lane]);
                    }
                }
            }
            out[i] = best_;
        }
        seed = out[count - 1].slot;
        return true;
    }

    /// How many places the next walk should share: many on coarse meshes, few where each has its own triangles.
    [[nodiscard]] std::size_t next_size(std::size_t size) const {
        constexpr std::size_t kFew = 12 * (8 / kPieceLanes);
        return listed_ <= kFew ? (size < kGroup ? size * 2 : kGroup)
                               : (listed_ > 2 * kFew && size > 4 ? size / 2 : size);
    }

private:
    struct Waiting {
        float distance;
        std::uint32_t child;
    };

    void start(const Vec3& place, const NearestSlot& best) {
        p_ = {Doubles{} + place.x, Doubles{} + place.y, Doubles{} + place.z};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low_[axis] = Floats{} + static_cast<float>(place[axis]);
        }
        best_ = best;
    }

    /// Distances of the group's other places to the triangle that the first one found; returns the largest, squared.
    double guess(const Vec3* places, std::size_t count, NearestSlot* out) const {
        const std::uint32_t slot = out[0].slot;
        V corner[3];
        for (std::size_t k = 0; k < 3; ++k) {
            const auto& c = leaves_[slot / 8].corner[k];
            corner[k] = {Doubles{} + c[0][slot % 8], Doubles{} + c[1][slot % 8], Doubles{} + c[2][slot % 8]};
        }
        double most = out[0].squared;
        for (std::size_t at = 0; at < count; at += SC_LANES) {
            double lanes[3][SC_LANES];
            for (std::size_t i = 0; i < SC_LANES; ++i) {
                const Vec3& place = places[at + i < count ? at + i : count - 1];
                lanes[0][i] = place.x;
                lanes[1][i] = place.y;
                lanes[2][i] = place.z;
            }
            const V p{load(lanes[0]), load(lanes[1]), load(lanes[2])};
            const Doubles squared = to_triangles(corner[0], corner[1], corner[2], p);
            for (std::size_t i = at == 0 ? 1 : 0; i < SC_LANES && at + i < count; ++i) {
                out[at + i] = {squared[i], slot};
                most = squared[i] > most ? squared[i] : most;
            }
        }
        return most;
    }

    /// Pieces of leaves that may hold the nearest triangle of any place of the group.
    bool list_pieces(const Vec3* places, std::size_t count, float limit) {
        Floats low[3];
        Floats high[3];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            float least = static_cast<float>(places[0][axis]);
            float most = least;
            for (std::size_t i = 1; i < count; ++i) {
                const auto v = static_cast<float>(places[i][axis]);
                least = v < least ? v : least;
                most = v > most ? v : most;
            }
            low[axis] = Floats{} + least;
            high[axis] = Floats{} + most;
        }
        listed_ = 0;
        std::size_t depth = 0;
        stack_[depth++] = {0.0F, 0};
        while (depth > 0) {
            const TreeNode& node = nodes_[stack_[--depth].child];
            const Boxes boxes = load_boxes(node);
            unsigned hits = below(to_boxes(boxes, low, high), limit);
            while (hits != 0) {
                const auto lane = static_cast<unsigned>(__builtin_ctz(hits));
                hits &= hits - 1;
                const std::uint32_t child = node.child[lane];
                if ((child & kLeafBit) == 0) {
                    stack_[depth++] = {0.0F, child};
                } else if (!list_leaf(node, lane, child & ~kLeafBit)) {
                    return false;
                }
            }
        }
        for (std::size_t i = listed_; i % 8 != 0; ++i) {
            piece_low_[0][i] = std::numeric_limits<float>::infinity();
            piece_high_[0][i] = -std::numeric_limits<float>::infinity();
            for (std::size_t axis = 1; axis < 3; ++axis) {
                piece_low_[axis][i] = piece_high_[axis][i] = 0.0F;
            }
        }
        return true;
    }

    bool list_leaf(const TreeNode& node, unsigned lane, std::uint32_t leaf) {
        if (listed_ + 8 / kPieceLanes > kListed) {
            return false;
        }
        if constexpr (kPieceLanes == 8) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                piece_low_[axis][listed_] = node.low[axis][lane];
                piece_high_[axis][listed_] = node.high[axis][lane];
            }
            piece_[listed_++] = leaf * 8;
        } else {
            for (std::uint32_t half = 0; half < 2; ++half) {
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    piece_low_[axis][listed_] = leaves_[leaf].half[half][0][axis];
                    piece_high_[axis][listed_] = leaves_[leaf].half[half][1][axis];
                }
                piece_[listed_++] = leaf * 8 + 4 * half;
            }
        }
        return true;
    }

    void test_leaf(std::uint32_t leaf) {
        for (std::uint32_t lane = 0; lane < 8; lane += SC_LANES) {
            test_lanes(leaf * 8 + lane);
        }
    }
    void test_piece(std::uint32_t slot) {
        for (std::uint32_t lane = 0; lane < kPieceLanes; lane += SC_LANES) {
            test_lanes(slot + lane);
        }
    }

    void test_lanes(std::uint32_t slot) {
        const TreeLeaf& leaf = leaves_[slot / 8];
        const std::size_t lane = slot % 8;
        const Doubles squared =
            to_triangles(load_corner(leaf, 0, lane), load_corner(leaf, 1, lane), load_corner(leaf, 2, lane), p_);
        unsigned hits = below(squared, best_.squared);
        if (hits == 0) {
            return;
        }
        while (hits != 0) {
            const auto i = static_cast<unsigned>(__builtin_ctz(hits));
            hits &= hits - 1;
            if (squared[i] < best_.squared) {
                best_ = {squared[i], slot + i};
            }
        }
        limit_ = widened(best_.squared);
    }

    // NOLINTBEGIN(cppcoreguidelines-pro-type-member-init): large, and written before they are read
    const TreeNode* nodes_;
    const TreeLeaf* leaves_;
    V p_;
    Floats low_[3];
    NearestSlot best_;
    float limit_ = 0.0F;
    std::size_t listed_ = 0;
    alignas(32) float piece_low_[3][kListed];
    alignas(32) float piece_high_[3][kListed];
    std::uint32_t piece_[kListed];
    Waiting stack_[512];
    // NOLINTEND(cppcoreguidelines-pro-type-member-init)
};

void nearest(const NearestTree& tree, std::span<const Vec3> places, std::span<NearestSlot> out, std::uint32_t& seed) {
    Walk walk(tree);
    std::size_t size = kGroup / 2;
    for (std::size_t at = 0; at < places.size();) {
        const std::size_t left = places.size() - at;
        const std::size_t count = size < left ? size : left;
        if (count > 1 && walk.nearest_of_group(&places[at], count, &out[at], seed)) {
            size = walk.next_size(size);
            at += count;
            continue;
        }
        // Too far apart to share a walk: one by one, and fewer at a time from here on.
        const std::size_t done = count > 1 ? 1 : 0;
        for (std::size_t i = done; i < count; ++i) {
            out[at + i] = walk.nearest(places[at + i], seed);
            seed = out[at + i].slot;
        }
        size = size > 4 ? size / 2 : 4;
        at += count;
    }
}

}  // namespace
}  // namespace sc::host::SC_KERNEL
