// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host/formats/mesh.hpp"

/// The tree of boxes that distance queries walk, and its kernels. For the sources of this folder only.

namespace sc::host {

/// Eight boxes in single precision, widened so that rounding never hides a triangle. Unused ones are infinitely far.
struct alignas(32) TreeNode {
    std::array<std::array<float, 8>, 3> low;
    std::array<std::array<float, 8>, 3> high;
    std::array<std::uint32_t, 8> child;  ///< a node, or a leaf with kLeafBit
};
inline constexpr std::uint32_t kLeafBit = 0x80000000U;

/// Eight triangles in double precision; lanes that are left over repeat the first.
struct alignas(64) TreeLeaf {
    std::array<std::array<std::array<double, 8>, 3>, 3> corner;  ///< [corner][axis][lane]
    std::array<std::uint32_t, 8> triangle;
    std::array<std::array<std::array<float, 3>, 2>, 2> half;  ///< boxes of lanes 0..3 and 4..7: [half][low, high][axis]
};

/// Places are relative to `centre`, so that single precision is spent on the part and not on where it lies.
struct NearestTree {
    Vec3 centre;
    std::vector<TreeNode> nodes;  ///< the first is the root
    std::vector<TreeLeaf> leaves;
};

/// Splits by the surface-area heuristic, counted in whole leaves. O(n log n).
[[nodiscard]] NearestTree build_nearest_tree(const TriangleMesh& mesh);

/// The nearest triangle of one query so far: squared distance (m²) and leaf · 8 + lane.
struct NearestSlot {
    double squared = 0.0;
    std::uint32_t slot = 0;
};

/// Nearest triangle of each place (relative to the tree's centre). Neighbours in `places` should be neighbours in
/// space: the answer of one is the first guess for the next. `seed` is the guess for the first, and is left for the
/// next call.
using NearestKernel = void (*)(const NearestTree& tree, std::span<const Vec3> places, std::span<NearestSlot> out,
                               std::uint32_t& seed);

void nearest_baseline(const NearestTree& tree, std::span<const Vec3> places, std::span<NearestSlot> out,
                      std::uint32_t& seed);
void nearest_avx2(const NearestTree& tree, std::span<const Vec3> places, std::span<NearestSlot> out,
                  std::uint32_t& seed);
void nearest_avx512(const NearestTree& tree, std::span<const Vec3> places, std::span<NearestSlot> out,
                    std::uint32_t& seed);

}  // namespace sc::host
