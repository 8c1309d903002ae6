// SPDX-License-Identifier: Apache-2.0
#include "host/path/profile.hpp"

#include <cmath>

namespace sc::host {

double speed_up_time(double speed, const MoveLimits& limits) noexcept {
    const double a = limits.acceleration;
    const double j = limits.jerk;
    return speed * j >= a * a ? speed / a + a / j : 2.0 * std::sqrt(speed / j);
}

double speed_up_distance(double speed, const MoveLimits& limits) noexcept {
    return 0.5 * speed * speed_up_time(speed, limits);
}

double move_time(double distance, const MoveLimits& limits) noexcept {
    const double d = std::abs(distance);
    const double v = limits.speed;
    const double a = limits.acceleration;
    const double j = limits.jerk;
    if (d >= 2.0 * speed_up_distance(v, limits)) {
        return d / v + speed_up_time(v, limits);
    }
    if (d >= 2.0 * a * a * a / (j * j)) {
        // d = v²/a + v·a/J with the peak speed v; the move takes 2·(v/a + a/J).
        const double ramp = a / j;
        return ramp + std::sqrt(ramp * ramp + 4.0 * d / a);
    }
    return 4.0 * std::cbrt(d / (2.0 * j));
}

}  // namespace sc::host
