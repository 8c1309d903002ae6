// SPDX-License-Identifier: Apache-2.0
#include "host/path/route.hpp"

#include <cmath>
#include <limits>

namespace sc::host {

namespace {
Stroke reversed(const Stroke& stroke) noexcept { return {stroke.to, stroke.from}; }
}  // namespace

double across(const Vec3& a, const Vec3& b) noexcept { return std::hypot(a.x - b.x, a.z - b.z); }

std::vector<std::size_t> nearest_first(const Vec3& start, std::span<const Vec3> places) {
    std::vector<std::size_t> order;
    std::vector<bool> taken(places.size(), false);
    Vec3 at = start;
    while (order.size() < places.size()) {
        std::size_t best = 0;
        double least = std::numeric_limits<double>::max();
        for (std::size_t i = 0; i < places.size(); ++i) {
            const double distance = across(at, places[i]);
            if (!taken[i] && distance < least) {
                least = distance;
                best = i;
            }
        }
        taken[best] = true;
        order.push_back(best);
        at = places[best];
    }
    return order;
}

Stroke nearer_end_first(const Vec3& at, const Stroke& stroke) noexcept {
    return across(at, stroke.to) < across(at, stroke.from) ? reversed(stroke) : stroke;
}

StrokeOrder order_pair(const Vec3& at, const Stroke& a, const Stroke& b) noexcept {
    StrokeOrder best;
    double least = std::numeric_limits<double>::max();
    for (const bool swapped : {false, true}) {
        for (const bool turn_first : {false, true}) {
            const Stroke& leading = swapped ? b : a;
            const Stroke first = turn_first ? reversed(leading) : leading;
            const Stroke second = nearer_end_first(first.to, swapped ? a : b);
            const double way = across(at, first.from) + across(first.to, second.from);
            if (way < least - 1e-12) {
                least = way;
                best = {first, second, swapped};
            }
        }
    }
    return best;
}

}  // namespace sc::host
