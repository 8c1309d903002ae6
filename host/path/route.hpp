// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "shared/geometry/vec.hpp"

/// The order in which a face is burnt: nearest first. Depth is left out: between paths the focus stays near the face.

namespace sc::host {

/// Indices of `places` in the order of a nearest-neighbour tour from `start`; equal distances keep the given order.
/// O(n²).
[[nodiscard]] std::vector<std::size_t> nearest_first(const Vec3& start, std::span<const Vec3> places);

/// A straight line between two places; which end comes first is free.
struct Stroke {
    Vec3 from;
    Vec3 to;
};
/// The cheaper direction of one line, seen from `at`.
[[nodiscard]] Stroke nearer_end_first(const Vec3& at, const Stroke& stroke) noexcept;

struct StrokeOrder {
    Stroke first;
    Stroke second;
    bool swapped = false;  ///< the second of the given pair comes first
};
/// Order and directions of two strokes with the least dark way from `at`. Four candidates, each with the better end of
/// the second stroke; the first best wins.
[[nodiscard]] StrokeOrder order_pair(const Vec3& at, const Stroke& a, const Stroke& b) noexcept;

/// Distance across the beam (x, z).
[[nodiscard]] double across(const Vec3& a, const Vec3& b) noexcept;

}  // namespace sc::host
