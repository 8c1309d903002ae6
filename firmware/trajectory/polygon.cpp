// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/polygon.hpp"

#include "shared/math/scalar.hpp"

namespace sc::trajectory {
namespace {

constexpr double kRounding = 1e-10;  ///< of the area of the box about a polygon: a vertex of less is none
constexpr double kInside = 1e-2;     ///< of that area: the double area with a side that a kept state must have
constexpr double kPrecious = 1e6;

}  // namespace

void Polygon::box(double b_most, double c_most) noexcept {
    count = 4;
    b[0] = b[3] = 0.0;
    b[1] = b[2] = b_most;
    c[0] = c[1] = -c_most;
    c[2] = c[3] = c_most;
}

void Polygon::clip(double nb, double nc, double d) noexcept {
    if (cut(*this, nb, nc, d) && count >= kCapacity - 1) {
        simplify(kCapacity - 8);
    }
}

void Polygon::clip_both(double nb, double nc, double d) noexcept {
    double most = 0.0;
    double least = 0.0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const double f = nb * b[i] + nc * c[i];
        most = larger(most, f);
        least = smaller(least, f);
    }
    if (most > d) {
        clip(nb, nc, d);
    }
    if (least < -d) {
        clip(-nb, -nc, d);
    }
}

void Polygon::simplify(std::uint32_t most, const State* kept) noexcept {
    if (count < 4) {
        return;
    }
    State low = at(0);
    State high = at(0);
    for (std::uint32_t i = 1; i < count; ++i) {
        low = {smaller(low.b, b[i]), smaller(low.c, c[i])};
        high = {larger(high.b, b[i]), larger(high.c, c[i])};
    }
    const double box = (high.b - low.b) * (high.c - low.c);
    std::array<double, kCapacity> area;
    const auto measure = [&](std::uint32_t i) noexcept {
        const State a = at(i == 0 ? count - 1 : i - 1);
        const State e = at(i + 1 == count ? 0 : i + 1);
        const State side{e.b - a.b, e.c - a.c};
        area[i] = absolute((a.b - b[i]) * side.c - side.b * (a.c - c[i]));
        if (kept != nullptr && area[i] > kRounding * box &&
            side.b * (kept->c - a.c) - side.c * (kept->b - a.b) < kInside * box) {
            area[i] *= kPrecious;
        }
    };
    for (std::uint32_t i = 0; i < count; ++i) {
        measure(i);
    }
    while (count > 3) {
        std::uint32_t least = 0;
        for (std::uint32_t i = 1; i < count; ++i) {
            least = area[i] < area[least] ? i : least;
        }
        if (count <= most && area[least] > kRounding * box) {
            return;
        }
        --count;
        for (std::uint32_t i = least; i < count; ++i) {
            move(i, i + 1);
            area[i] = area[i + 1];
        }
        measure(least == count ? 0 : least);
        measure(least == 0 ? count - 1 : least - 1);
    }
}

void StoredPolygon::store(const Polygon& polygon) noexcept {
    count = polygon.count < kCapacity ? polygon.count : kCapacity;
    for (std::uint32_t i = 0; i < count; ++i) {
        b[i] = polygon.b[i];
        c[i] = polygon.c[i];
    }
}

}  // namespace sc::trajectory
