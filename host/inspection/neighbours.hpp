// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "shared/geometry/vec.hpp"

namespace sc::host {

/// Cells of a grid, each with its points; neighbours along x are neighbours in the list. O(n log n) to build, some 0.5
/// µs a question. `places` must outlive it.
class Neighbours {
public:
    Neighbours(std::span<const Vec3> places, double reach);

    /// Indices of the points within reach of a place; at most as many as fit.
    [[nodiscard]] std::size_t at(const Vec3& place, std::span<std::uint32_t> out) const;
    /// The same about one of them, itself left out.
    [[nodiscard]] std::size_t about(std::uint32_t i, std::span<std::uint32_t> out) const;

private:
    [[nodiscard]] std::uint64_t key(const Vec3& p, int dx, int dy, int dz) const;
    [[nodiscard]] std::size_t found(const Vec3& place, std::uint32_t but, std::span<std::uint32_t> out) const;

    std::span<const Vec3> places_;
    double reach_;
    Vec3 low_;
    std::vector<std::pair<std::uint64_t, std::uint32_t>> cells_;
};

}  // namespace sc::host
