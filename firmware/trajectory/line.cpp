// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/line.hpp"

#include "firmware/trajectory/place.hpp"
#include "shared/math/scalar.hpp"

namespace sc::trajectory {
namespace {

constexpr double kShare = 0.9995;   ///< of tolerance, jerk and time at corners, for rounding
constexpr double kStubShare = 0.6;  ///< of a stub, used by the ramp

constexpr double kOutward = 0.33;    ///< of the tolerance
constexpr double kLonger = 1.02;     ///< overlap that is worth a lower jerk
constexpr double kShortest = 1e-12;  ///< s; a cruise below is rounding

/// A ramp that a line begins with, seen as part of a change of speed with the line's own jerk that began earlier, from
/// a virtual speed.
struct Start {
    double v = 0.0;  ///< at the ramp's end
    double a = 0.0;
    double s = 0.0;  ///< covered by the ramp
    double virtual_v = 0.0;
    double virtual_s = 0.0;  ///< covered from the virtual start to the ramp's end
    double virtual_t = 0.0;
};

Start make_start(const Joint& joint, double jerk) noexcept {
    Start start;
    const double t = joint.duration;
    start.a = joint.jerk * t;
    start.v = 0.5 * start.a * t;
    start.s = start.v * t * (1.0 / 3.0);
    start.virtual_t = start.a / jerk;
    start.virtual_v = start.v - 0.5 * start.a * start.virtual_t;
    start.virtual_s = start.virtual_t * (start.virtual_v + start.a * start.virtual_t * (1.0 / 6.0));
    return start;
}

double change_time(double dv, const Along& limits) noexcept {
    return dv * limits.jerk <= limits.acceleration * limits.acceleration
               ? 2.0 * square_root(dv / limits.jerk)
               : dv / limits.acceleration + limits.acceleration / limits.jerk;
}

/// From rest, through the ramp, to `peak`.
double distance_to(const Start& start, double peak, const Along& limits) noexcept {
    const double dv = peak - start.virtual_v;
    return start.s - start.virtual_s + 0.5 * (peak + start.virtual_v) * change_time(dv, limits);
}

/// The three stretches from the ramp's end up to `peak`, seen forward in time.
struct Rise {
    double up = 0.0;
    double hold = 0.0;
    double down = 0.0;
};

Rise make_rise(const Start& start, double peak, const Along& limits) noexcept {
    const double dv = peak - start.virtual_v;
    const double a = limits.acceleration;
    if (dv * limits.jerk <= a * a) {
        const double t = square_root(larger(dv, 0.0) / limits.jerk);
        return {larger(t - start.virtual_t, 0.0), 0.0, t};
    }
    const double t = a / limits.jerk;
    return {larger(t - start.virtual_t, 0.0), dv / a - t, t};
}

}  // namespace

Along limits_along(const Limits& limits, const Place& direction) noexcept {
    const double travel = length3(direction);
    Along found{1e12, 1e12, 1e12};
    if (travel > 0.0) {
        found.speed = limits.speed / travel;
    }
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double d = absolute(direction[k]);
        if (d > 0.0) {
            found.speed = smaller(found.speed, limits.velocity[k] / d);
            found.acceleration = smaller(found.acceleration, limits.acceleration[k] / d);
            found.jerk = smaller(found.jerk, limits.jerk[k] / d);
        }
    }
    return found;
}

namespace {

double duration_at(double length, const Along& limits) noexcept {
    const LinePlan plan = plan_line(length, limits, {}, {});
    double sum = 0.0;
    for (std::uint32_t i = 0; i < plan.count; ++i) {
        sum += plan.phase[i].duration;
    }
    return sum;
}

/// The larger of sin θ and √2·sin(θ/2): deviation from the legs and from the corner, per k.
double width(const Place& d1, const Place& d2) noexcept {
    const double cosine = clamped(dot(d1, d2) / (length(d1) * length(d2)), -1.0, 1.0);
    return larger(square_root(1.0 - cosine * cosine), square_root(1.0 - cosine));
}

}  // namespace

Outward move_corner(const Limits& limits, const Stub& before, const Stub& after) noexcept {
    Outward outward;
    const double tolerance = limits.tolerance;
    outward.room = tolerance;
    const double shorter = smaller(before.length, after.length);
    const double widest = width(before.direction, after.direction);
    if (!before.whole || !after.whole || !(widest > 0.0) || shorter < 6.0 * tolerance || tolerance < 1e-7) {
        return outward;
    }
    const double slender = tolerance / shorter;
    const double share = kOutward * (1.0 - 6.0 * slender);
    outward.shift = times(share * tolerance / widest, minus(before.direction, after.direction));
    // The lines turn a little, and where the corner is rounded they are moved less than at the corner.
    outward.room = tolerance * (1.0 + share * (1.0 - 4.0 * slender)) * (1.0 - 2.0 * share * slender);
    return outward;
}

Joint make_joint(const Limits& limits, const Stub& before, const Stub& after, double room) noexcept {
    const Place& d1 = before.direction;
    const Place& d2 = after.direction;
    const Along along1 = limits_along(limits, d1);
    const Along along2 = limits_along(limits, d2);
    const double alone = kShare * smaller(along1.jerk, along2.jerk);
    double ramps = alone;   // both on their ramps: the jerks add up
    double phases = alone;  // any phase with any other: their magnitudes do
    double most = square_root(smaller(along1.speed, along2.speed) / alone);
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double sum = absolute(d1[k] + d2[k]);
        const double magnitudes = absolute(d1[k]) + absolute(d2[k]);
        if (sum > 0.0) {
            ramps = smaller(ramps, kShare * limits.jerk[k] / sum);
        }
        if (magnitudes > 0.0) {
            phases = smaller(phases, kShare * limits.jerk[k] / magnitudes);
            most = smaller(most, limits.acceleration[k] / (magnitudes * alone));
        }
    }
    const double widest = width(d1, d2);
    if (!(limits.tolerance >= 1e-7) || !(widest > 0.0)) {
        return {0.0, ramps};
    }
    const auto by_tolerance = [&](double jerk) noexcept {
        return smaller(cube_root(48.0 * kShare * room / (jerk * widest)), kShare * most);
    };
    // How long each side can stay on its ramp, and how long it can be overlapped at all.
    const auto ramp = [](const Stub& stub, const Along& along, double jerk) noexcept {
        return kShare * (stub.whole ? cube_root(stub.length / (2.0 * along.jerk))
                                    : cube_root(6.0 * kStubShare * stub.length / jerk));
    };
    // A line that leaves its ramp early keeps to at most this jerk throughout, and both its ends may be overlapped.
    const auto half = [&](const Stub& stub, const Along& along, double jerk) noexcept {
        return stub.whole ? 0.5 * kShare * duration_at(stub.length, {along.speed, along.acceleration, jerk})
                          : ramp(stub, along, jerk);
    };
    const Joint on_ramps{smaller(by_tolerance(ramps), smaller(ramp(before, along1, ramps), ramp(after, along2, ramps))),
                         ramps};
    const Joint on_phases{
        smaller(by_tolerance(phases), smaller(half(before, along1, phases), half(after, along2, phases))), phases};
    return on_phases.duration > kLonger * on_ramps.duration ? on_phases : on_ramps;
}

LinePlan plan_line(double length, const Along& line, const Joint& head_joint, const Joint& tail_joint) noexcept {
    Along limits = line;
    Joint head = head_joint;
    Joint tail = tail_joint;
    Start from = make_start(head, limits.jerk);
    Start to = make_start(tail, limits.jerk);
    // Least peak: the acceleration of the ramps is only taken back.
    const auto least_peak = [&] {
        return larger(from.virtual_v + from.a * from.virtual_t, to.virtual_v + to.a * to.virtual_t);
    };
    const auto used = [&](double peak) noexcept {
        return distance_to(from, peak, limits) + distance_to(to, peak, limits);
    };
    if (used(least_peak()) > length) {
        limits.jerk = smaller(limits.jerk, smaller(head.jerk, tail.jerk));
        head = tail = {};
        from = to = {};
    }
    const double least = least_peak();
    double peak = limits.speed;
    LinePlan plan;
    if (used(peak) > length) {
        double low = least;
        double high = peak;
        for (int i = 0; i < 60; ++i) {
            const double middle = 0.5 * (low + high);
            (used(middle) > length ? high : low) = middle;
        }
        peak = low;
    }
    const Rise rise = make_rise(from, peak, limits);
    const Rise fall = make_rise(to, peak, limits);
    const double j = limits.jerk;
    double s = 0.0;
    double v = 0.0;
    double a = 0.0;
    const auto add = [&](double duration, double jerk) noexcept {
        if (!(duration > 0.0)) {
            return;
        }
        plan.phase[plan.count++] = {duration, s, v, a, jerk};
        s += duration * (v + duration * (0.5 * a + duration * jerk * (1.0 / 6.0)));
        v += duration * (a + duration * 0.5 * jerk);
        a += duration * jerk;
    };
    add(head.duration, head.jerk);
    add(rise.up, j);
    add(rise.hold, 0.0);
    add(rise.down, -j);
    // The phases of the fall count from the end, so that it is met exactly; the cruise takes what is between.
    std::array<Phase, 4> back{};
    std::uint32_t backs = 0;
    double to_go = 0.0;
    double vb = 0.0;
    double ab = 0.0;
    const auto prepend = [&](double duration, double jerk) noexcept {
        if (!(duration > 0.0)) {
            return;
        }
        const double end_s = to_go;
        to_go = end_s + duration * (vb + duration * (0.5 * ab + duration * jerk * (1.0 / 6.0)));
        vb += duration * (ab + duration * 0.5 * jerk);
        ab += duration * jerk;
        back[backs++] = {duration, length - to_go, vb, -ab, jerk};
    };
    prepend(tail.duration, tail.jerk);
    prepend(fall.up, j);
    prepend(fall.hold, 0.0);
    prepend(fall.down, -j);
    const double cruise = (length - to_go - s) / peak;
    if (cruise > kShortest) {
        plan.phase[plan.count++] = {cruise, s, peak, 0.0, 0.0};
    }
    while (backs > 0) {
        plan.phase[plan.count++] = back[--backs];
    }
    return plan;
}

}  // namespace sc::trajectory
