// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/profile.hpp"

#include "shared/math/scalar.hpp"

namespace sc::motion {
namespace {

constexpr double kSmallestChange = 1e-9;  ///< of the speed
constexpr int kPeakSteps = 24;
constexpr double kPeakRest = 1e-9;  ///< share of the distance that the search for the peak may leave to a cruise

}  // namespace

double change_time(double v0, double v1, const TangentLimits& limits) noexcept {
    const double dv = absolute(v1 - v0);
    const double a = limits.acceleration;
    const double j = limits.jerk;
    if (dv * j <= a * a) {
        return 2.0 * square_root(dv / j);
    }
    return dv / a + a / j;
}

double change_distance(double v0, double v1, const TangentLimits& limits) noexcept {
    return 0.5 * (v0 + v1) * change_time(v0, v1, limits);
}

double reachable_speed(double v0, double distance, const TangentLimits& limits) noexcept {
    if (!(distance > 0.0)) {
        return v0;
    }
    const double a = limits.acceleration;
    const double j = limits.jerk;
    const double dv_full = a * a / j;
    // Up to dv_full, with r = sqrt(dv): (2 v0 + r²) r = L sqrt(j), a cubic that rises everywhere for r > 0.
    if (change_distance(v0, v0 + dv_full, limits) >= distance) {
        const double target = distance * square_root(j);
        // Newton from above converges monotonically, because the cubic is convex: never below the root, so step back at
        // the end.
        double r = smaller(cube_root(target), v0 > 0.0 ? target / (2.0 * v0) : cube_root(target));
        r = larger(r, 1e-12);
        for (int i = 0; i < 12; ++i) {
            r -= ((2.0 * v0 + r * r) * r - target) / (2.0 * v0 + 3.0 * r * r);
        }
        r *= 1.0 - 1e-13;
        // A change that v0 + dv can only hold to a few digits would be paid for by picometres of distance.
        return r > 0.0 && r * r > kSmallestChange * v0 ? v0 + r * r : v0;
    }
    // (v0 + v1)/2 · ((v1 − v0)/a + a/j) = L: v1² + k v1 − (v0² − k v0 + 2 a L) = 0 with k = a²/j.
    const double k = dv_full;
    const double c = v0 * v0 - k * v0 + 2.0 * a * distance;
    const double v1 = 0.5 * (square_root(k * k + 4.0 * c) - k);
    return larger(v0, v1 * (1.0 - 1e-13));
}

double lowest_speed(double v0, double distance, const TangentLimits& limits) noexcept {
    if (change_distance(v0, 0.0, limits) <= distance) {
        return 0.0;
    }
    // No change takes no distance, so `high` always fits: bisection with a fixed number of steps.
    double low = 0.0;
    double high = v0;
    for (int i = 0; i < 56; ++i) {
        const double middle = 0.5 * (low + high);
        (change_distance(v0, middle, limits) > distance ? low : high) = middle;
    }
    return high;
}

void PhaseList::add(double duration, double jerk, double start_acceleration) noexcept {
    if (duration > 0.0 && count < phase.size()) {
        phase[count] = {duration, jerk, start_acceleration};
        ++count;
    }
}

void PhaseList::add_change(double v0, double v1, const TangentLimits& limits) noexcept {
    const double dv = absolute(v1 - v0);
    if (!(dv > 0.0)) {
        return;
    }
    const double sign = v1 > v0 ? 1.0 : -1.0;
    const double a = limits.acceleration;
    const double j = limits.jerk;
    if (dv * j <= a * a) {
        const double ramp = square_root(dv / j);
        add(ramp, sign * j, 0.0);
        add(ramp, -sign * j, sign * j * ramp);
        return;
    }
    const double ramp = a / j;
    add(ramp, sign * j, 0.0);
    add(dv / a - ramp, 0.0, sign * a);
    add(ramp, -sign * j, sign * a);
}

namespace {

/// Highest speed in [low, high] that uses no more than `distance`; `used` rises, used(low) ≤ distance < used(high).
/// Regula falsi with the Illinois rule over the root of the speed above `low`, in which the distance is nearly
/// straight: four to six steps. What the steps leave unused is a cruise.
template <class Used>
double highest_peak(const Used& used, double low, double high, double distance) noexcept {
    double fits = 0.0;
    double over = square_root(high - low);
    double rest = used(low) - distance;  // ≤ 0
    double excess = used(high) - distance;
    int last = 0;
    for (int i = 0; i < kPeakSteps && -rest > kPeakRest * distance; ++i) {
        const double root = (fits * excess - over * rest) / (excess - rest);
        const double at = used(low + root * root) - distance;
        if (at > 0.0) {
            over = root;
            excess = at;
            rest = last > 0 ? 0.5 * rest : rest;
            last = 1;
        } else {
            fits = root;
            rest = at;
            excess = last < 0 ? 0.5 * excess : excess;
            last = -1;
        }
    }
    return low + fits * fits;
}

}  // namespace

PhaseList fastest_profile(double v0, double v1, double cap, double distance, const TangentLimits& limits) noexcept {
    const auto used = [&](double peak) noexcept {
        return change_distance(v0, peak, limits) + change_distance(peak, v1, limits);
    };
    const double peak = used(cap) > distance ? highest_peak(used, larger(v0, v1), cap, distance) : cap;
    PhaseList list;
    list.add_change(v0, peak, limits);
    const double rest = distance - used(peak);
    if (peak > 0.0 && rest > 0.0) {
        list.add(rest / peak, 0.0, 0.0);
    }
    list.add_change(peak, v1, limits);
    return list;
}

}  // namespace sc::motion
