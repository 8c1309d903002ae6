// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace sc::trajectory {

/// Convex set of states of the path parameter s: b = ṡ², c = db/ds. Vertices run from +b to +c.
struct Polygon {
    static constexpr std::uint32_t kCapacity = 48;
    std::uint32_t count = 0;
    std::array<double, kCapacity> b;
    std::array<double, kCapacity> c;
    std::array<bool, kCapacity> seen;  ///< for the user: vertices made by clip() and box() begin as false

    /// Keeps what fulfils nb·b + nc·c ≤ d. Cost: 4 operations a vertex when nothing is cut.
    void clip(double nb, double nc, double d) noexcept;
    /// Drops vertices, least area first, until `most` remain: what is left lies within.
    void simplify(std::uint32_t most) noexcept;
    void box(double b_most, double c_most) noexcept;
};

/// A polygon as it is kept for each node.
struct StoredPolygon {
    static constexpr std::uint32_t kCapacity = 14;
    std::uint32_t count = 0;
    std::array<double, kCapacity> b;
    std::array<double, kCapacity> c;

    void store(const Polygon& polygon) noexcept;
};

}  // namespace sc::trajectory
