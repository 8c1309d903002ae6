// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/piece.hpp"

#include "shared/math/scalar.hpp"

namespace sc::trajectory {

Quintic hermite(const Motion& from, const Motion& to, double duration) noexcept {
    const double t = duration;
    const double r = 1.0 / t;
    const double d = (to.p - from.p) - t * (from.v + 0.5 * t * from.a);
    const double e = t * ((to.v - from.v) - t * from.a);
    const double f = 0.5 * t * t * (to.a - from.a);
    const double r3 = r * r * r;
    // 10 d − 4 e + f, −15 d + 7 e − 2 f and 6 d − 3 e + f, without sums beside differences: of products, GCC 12 makes
    // fused operations of those although it is told not to.
    const double g = 2.0 * d - e;
    return {from.p,
            from.v,
            0.5 * from.a,
            (5.0 * g + (e + f)) * r3,
            (7.5 * g + (0.5 * e + 2.0 * f)) * (-r3 * r),
            (3.0 * g + f) * (r3 * r * r)};
}

Peaks peaks(const Quintic& k, double duration) noexcept {
    Peaks found;
    const auto acceleration_at = [&](double t) noexcept {
        if (t > 0.0 && t < duration) {
            found.acceleration = larger(found.acceleration, absolute(second_rate(k, t)));
        }
    };
    found.acceleration = larger(absolute(2.0 * k[2]), absolute(second_rate(k, duration)));
    const double end = third_rate(k, duration);
    found.jerk = larger(absolute(6.0 * k[3]), absolute(end));
    // Jerk 6 k3 + 24 k4 t + 60 k5 t²: its own extreme, and its roots, where the acceleration is extreme.
    const double a = 60.0 * k[5];
    const double b = 24.0 * k[4];
    const double c = 6.0 * k[3];
    const double top = -0.5 * b / a;
    if (top > 0.0 && top < duration) {
        found.jerk = larger(found.jerk, absolute(third_rate(k, top)));
    }
    const double q = b * b - 4.0 * a * c;
    if (q >= 0.0) {
        const double m = -0.5 * (b + (b < 0.0 ? -square_root(q) : square_root(q)));
        acceleration_at(m / a);
        acceleration_at(c / m);
    }
    return found;
}

}  // namespace sc::trajectory
