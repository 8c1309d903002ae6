// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/element.hpp"

#include "shared/math/scalar.hpp"

namespace sc::motion {
namespace {

/// Five-point Gauss-Legendre nodes and weights on [0, 1].
constexpr std::array<double, 5> kNode{0.046910077030668004, 0.23076534494715845, 0.5, 0.76923465505284155,
                                      0.95308992296933200};
constexpr std::array<double, 5> kWeight{0.11846344252809454, 0.23931433524968324, 0.28444444444444444,
                                        0.23931433524968324, 0.11846344252809454};

double smoothstep(double u) noexcept { return u * u * (3.0 - 2.0 * u); }

/// |d2 − d1|² over the linear axes.
double bend(const Element& e) noexcept {
    double sum = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const double d = e.d2[i] - e.d1[i];
        sum = sum + d * d;
    }
    return sum;
}

/// True length of a blend's first `u` of its parameter range: |q'|² = 1 − |d2 − d1|² w (1 − w) for unit directions.
double blend_length(const Element& e, double u) noexcept {
    const double k = bend(e);
    double sum = 0.0;
    for (std::size_t i = 0; i < kNode.size(); ++i) {
        const double w = smoothstep(u * kNode[i]);
        sum = sum + kWeight[i] * square_root(1.0 - k * w * (1.0 - w));
    }
    return sum * u * e.length;
}

}  // namespace

Place Element::place(double tau) const noexcept {
    const double t = clamped(tau - start, 0.0, length);
    Place p{};
    if (kind == Kind::line) {
        for (std::size_t i = 0; i < kAxisCount; ++i) {
            p[i] = origin[i] + d1[i] * t;
        }
        return p;
    }
    const double u = t / length;
    const double second = length * (u * u * u * (1.0 - 0.5 * u));
    const double first = t - second;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        p[i] = origin[i] + (d1[i] * first + d2[i] * second);
    }
    return p;
}

double Element::distance_at(double tau) const noexcept {
    const double t = clamped(tau - start, 0.0, length);
    if (kind == Kind::line) {
        return distance + t;
    }
    const double u = t / length;
    // Symmetric about its middle, and the rule is the more accurate the shorter the range.
    return distance + (u <= 0.5 ? blend_length(*this, u) : true_length - blend_length(*this, 1.0 - u));
}

double Element::stretch_at(double tau) const noexcept {
    if (kind == Kind::line) {
        return 1.0;
    }
    const double w = smoothstep(clamped(tau - start, 0.0, length) / length);
    return square_root(1.0 - bend(*this) * w * (1.0 - w));
}

Element make_line(const Place& from, const Place& direction, double length, double speed,
                  const AxisLimits& axes) noexcept {
    Element e;
    e.kind = Element::Kind::line;
    e.length = length;
    e.true_length = length;
    e.origin = from;
    e.d1 = direction;
    e.d2 = direction;
    e.cap = speed;
    e.limits = {1e30, 1e30};
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const double share = absolute(direction[i]);
        if (share > 1e-12) {
            if (axes.speed[i] < e.cap * share) {
                e.cap = axes.speed[i] / share;
                e.limited = LimitedBy::axis_speed;
            }
            e.limits.acceleration = smaller(e.limits.acceleration, axes.acceleration[i] / share);
            e.limits.jerk = smaller(e.limits.jerk, axes.jerk[i] / share);
        }
    }
    return e;
}

Element make_blend(const Place& from, const Place& d1, const Place& d2, double half, double speed,
                   const AxisLimits& axes) noexcept {
    Element e;
    e.kind = Element::Kind::blend;
    e.length = 2.0 * half;
    e.origin = from;
    e.d1 = d1;
    e.d2 = d2;
    e.cap = speed;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const double share = larger(absolute(d1[i]), absolute(d2[i]));
        if (share > 1e-12 && axes.speed[i] < e.cap * share) {
            e.cap = axes.speed[i] / share;
            e.limited = LimitedBy::axis_speed;
        }
        const double turn = absolute(d2[i] - d1[i]);
        if (turn > 1e-15) {
            const double by_acceleration = square_root(axes.acceleration[i] * e.length / (1.5 * turn));
            const double by_jerk = cube_root(axes.jerk[i] * e.length * e.length / (6.0 * turn));
            const double corner = smaller(by_acceleration, by_jerk);
            if (corner < e.cap) {
                e.cap = corner;
                e.limited = LimitedBy::corner;
            }
        }
    }
    e.true_length = 2.0 * blend_length(e, 0.5);
    return e;
}

}  // namespace sc::motion
