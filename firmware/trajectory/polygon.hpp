// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace sc::trajectory {

/// State of the path parameter s: b = ṡ², c = db/ds.
struct State {
    double b = 0.0;
    double c = 0.0;
};

/// Convex set of states. Vertices run from +b to +c.
struct Polygon {
    static constexpr std::uint32_t kCapacity = 48;
    std::uint32_t count = 0;
    std::array<double, kCapacity> b;
    std::array<double, kCapacity> c;

    /// Keeps what fulfils nb·b + nc·c ≤ d. Cost: 8 instructions a vertex when nothing is cut.
    void clip(double nb, double nc, double d) noexcept;
    /// Keeps what fulfils |nb·b + nc·c| ≤ d. Cost: as one clip() when nothing is cut.
    void clip_both(double nb, double nc, double d) noexcept;
    /// Drops vertices, least area first, until `most` remain and none is but rounding: what is left lies within. Those
    /// without which `kept` would not be well inside go last.
    void simplify(std::uint32_t most, const State* kept = nullptr) noexcept;
    /// 0 ≤ b ≤ b_most, |c| ≤ c_most
    void box(double b_most, double c_most) noexcept;

    void move(std::uint32_t to, std::uint32_t from) noexcept {
        b[to] = b[from];
        c[to] = c[from];
    }
    void put(std::uint32_t i, const State& state) noexcept {
        b[i] = state.b;
        c[i] = state.c;
    }
    [[nodiscard]] State at(std::uint32_t i) const noexcept { return {b[i], c[i]}; }
};

/// A polygon as it is kept for each node.
struct StoredPolygon {
    static constexpr std::uint32_t kCapacity = 10;
    std::uint32_t count = 0;
    std::array<double, kCapacity> b;
    std::array<double, kCapacity> c;

    void store(const Polygon& polygon) noexcept;
};

/// Cuts off the part of a convex shape for which nb·b + nc·c > d. Where rounding leaves vertices outside in several
/// places, those about the worst go. False if nothing was cut. Needs room for one more vertex. A Shape has a Polygon's
/// count, at(), move() and put().
template <class Shape>
bool cut(Shape& shape, double nb, double nc, double d) noexcept {
    const std::uint32_t count = shape.count;
    std::array<double, Polygon::kCapacity> excess;
    double worst = 0.0;
    std::uint32_t first = count;
    for (std::uint32_t i = 0; i < count; ++i) {
        const State state = shape.at(i);
        const double f = nb * state.b + nc * state.c - d;
        excess[i] = f;
        if (f > worst) {
            worst = f;
            first = i;
        }
    }
    if (first == count) {
        return false;
    }
    const auto after = [&](std::uint32_t i) noexcept { return i + 1 == count ? 0 : i + 1; };
    const auto before = [&](std::uint32_t i) noexcept { return i == 0 ? count - 1 : i - 1; };
    std::uint32_t last = first;
    std::uint32_t outside = 1;
    while (outside < count && excess[before(first)] > 0.0) {
        first = before(first);
        ++outside;
    }
    while (outside < count && excess[after(last)] > 0.0) {
        last = after(last);
        ++outside;
    }
    if (outside == count) {
        shape.count = 0;
        return true;
    }
    const auto between = [&](std::uint32_t i, std::uint32_t k) noexcept {
        const double t = excess[i] / (excess[i] - excess[k]);
        const State a = shape.at(i);
        const State z = shape.at(k);
        return State{a.b + t * (z.b - a.b), a.c + t * (z.c - a.c)};
    };
    const State enter = between(before(first), first);
    const State leave = between(last, after(last));
    if (first > last) {
        // Those outside are at both ends of the array.
        const std::uint32_t kept = first - last - 1;
        for (std::uint32_t i = 0; i < kept; ++i) {
            shape.move(i, last + 1 + i);
        }
        shape.put(kept, enter);
        shape.put(kept + 1, leave);
        shape.count = kept + 2;
        return true;
    }
    if (first == last) {
        for (std::uint32_t i = count; i > first + 1; --i) {
            shape.move(i, i - 1);
        }
        ++shape.count;
    } else {
        const std::uint32_t gone = last - first - 1;
        for (std::uint32_t i = last + 1; gone > 0 && i < count; ++i) {
            shape.move(i - gone, i);
        }
        shape.count -= gone;
    }
    shape.put(first, enter);
    shape.put(first + 1, leave);
    return true;
}

}  // namespace sc::trajectory
