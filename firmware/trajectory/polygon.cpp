// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/polygon.hpp"

#include "shared/math/scalar.hpp"

namespace sc::trajectory {

void Polygon::box(double b_most, double c_most) noexcept {
    count = 4;
    seen.fill(false);
    b[0] = b[3] = 0.0;
    b[1] = b[2] = b_most;
    c[0] = c[1] = -c_most;
    c[2] = c[3] = c_most;
}

void Polygon::clip(double nb, double nc, double d) noexcept {
    std::array<double, kCapacity> excess;
    std::uint32_t outside = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const double f = nb * b[i] + nc * c[i] - d;
        excess[i] = f;
        outside += f > 0.0 ? 1U : 0U;
    }
    if (outside == 0) {
        return;
    }
    if (outside == count) {
        count = 0;
        return;
    }
    const Polygon whole = *this;
    count = 0;
    for (std::uint32_t i = 0; i < whole.count; ++i) {
        const std::uint32_t k = i + 1 == whole.count ? 0 : i + 1;
        const bool inside = !(excess[i] > 0.0);
        if (inside) {
            b[count] = whole.b[i];
            c[count] = whole.c[i];
            seen[count] = whole.seen[i];
            ++count;
        }
        if (inside != !(excess[k] > 0.0)) {
            const double t = excess[i] / (excess[i] - excess[k]);
            b[count] = whole.b[i] + t * (whole.b[k] - whole.b[i]);
            c[count] = whole.c[i] + t * (whole.c[k] - whole.c[i]);
            seen[count] = false;
            ++count;
        }
    }
    // A cut adds one vertex at most.
    if (count >= kCapacity - 1) {
        simplify(kCapacity - 4);
    }
}

void Polygon::simplify(std::uint32_t most) noexcept {
    while (count > most) {
        std::uint32_t least = 0;
        double least_area = 0.0;
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint32_t a = i == 0 ? count - 1 : i - 1;
            const std::uint32_t e = i + 1 == count ? 0 : i + 1;
            const double area = absolute((b[a] - b[i]) * (c[e] - c[i]) - (b[e] - b[i]) * (c[a] - c[i]));
            if (i == 0 || area < least_area) {
                least = i;
                least_area = area;
            }
        }
        for (std::uint32_t i = least; i + 1 < count; ++i) {
            b[i] = b[i + 1];
            c[i] = c[i + 1];
            seen[i] = seen[i + 1];
        }
        --count;
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
