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
double bend_squared(const Element& e) noexcept {
    return (e.bend[0] * e.bend[0] + e.bend[1] * e.bend[1]) + e.bend[2] * e.bend[2];
}

/// Length of the first half of a blend.
double half_length(const Element& e) noexcept {
    const double k = bend_squared(e);
    double sum = 0.0;
    for (std::size_t i = 0; i < kNode.size(); ++i) {
        const double w = smoothstep(0.5 * kNode[i]);
        sum = sum + kWeight[i] * square_root(1.0 - k * w * (1.0 - w));
    }
    return sum * (0.5 * e.length);
}

/// Fills true_length and odd. With x = z / h the polynomial is x (a + x² (b + x² (c + x² d))) and its four conditions,
/// L at x = 1, slopes 1 (end) and m (middle), no second derivative at the end, have this solution (h = 1, L over h).
void fit_length(Element& e) noexcept {
    const double half = 0.5 * e.length;
    const double l = half_length(e) / half;
    const double m = square_root(1.0 - 0.25 * bend_squared(e));
    const double rest = l - m;     // b + c + d
    const double slope = 1.0 - m;  // 3b + 5c + 7d
    const double d = (15.0 * rest - 7.0 * slope) / 8.0;
    const double c = 0.5 * (slope - 3.0 * rest) - 2.0 * d;
    const double b = rest - c - d;
    const double q = 1.0 / (half * half);
    e.true_length = 2.0 * (l * half);
    e.odd = {m, b * q, c * q * q, d * q * q * q};
}

}  // namespace

Place Element::place(double tau) const noexcept {
    const double t = clamped(tau - start, 0.0, length);
    const double b = bent(t);
    Place p{};
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        p[i] = axis(i, t, b);
    }
    return p;
}

double Element::distance_at(double tau) const noexcept {
    return distance + length_to(clamped(tau - start, 0.0, length));
}

Element make_line(const Place& from, const Place& direction, double length, double speed,
                  const AxisLimits& axes) noexcept {
    Element e;
    e.kind = Element::Kind::line;
    e.length = length;
    e.true_length = length;
    e.origin = from;
    e.d1 = direction;
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
    e.cubic = 1.0 / (e.length * e.length);
    e.quartic = 0.5 * e.cubic / e.length;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        e.bend[i] = d2[i] - d1[i];
    }
    e.cap = speed;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const double share = larger(absolute(d1[i]), absolute(d2[i]));
        if (share > 1e-12 && axes.speed[i] < e.cap * share) {
            e.cap = axes.speed[i] / share;
            e.limited = LimitedBy::axis_speed;
        }
        const double turn = absolute(e.bend[i]);
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
    fit_length(e);
    return e;
}

}  // namespace sc::motion
