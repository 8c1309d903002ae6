// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/arc.hpp"

#include "firmware/trajectory/place.hpp"
#include "shared/math/angle.hpp"

namespace sc::trajectory {
namespace {

constexpr double kMostTurn = 0.3;  ///< rad, of a chord

Place linear(const Place& p) noexcept { return {p[0], p[1], p[2], 0.0}; }

Place cross(const Place& a, const Place& b) noexcept {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0], 0.0};
}

}  // namespace

std::optional<Circle> circle_through(const Place& from, const Place& via, const Place& to) noexcept {
    const Place u = linear(minus(via, from));
    const Place w = linear(minus(to, from));
    const double uu = dot3(u, u);
    const double ww = dot3(w, w);
    const Place normal = cross(u, w);
    const double nn = dot3(normal, normal);
    if (!(nn > 1e-20 * uu * ww)) {
        return std::nullopt;
    }
    const Place to_centre = times(0.5 / nn, cross(minus(times(uu, w), times(ww, u)), normal));
    Circle circle;
    circle.radius = length3(to_centre);
    circle.centre = plus(linear(from), to_centre);
    circle.first = times(-1.0, to_centre);
    circle.second = times(1.0 / square_root(nn), cross(normal, circle.first));
    const Place end = minus(linear(to), circle.centre);
    circle.turn = angle_of(dot3(end, circle.first), dot3(end, circle.second));
    return circle;
}

ArcShape arc_shape(const Place& from, const Place& via, const Place& to) noexcept {
    ArcShape shape;
    const auto circle = circle_through(from, via, to);
    if (!circle) {
        const Place chord = linear(minus(to, from));
        const double length = length3(chord);
        shape.leaves = shape.arrives = length > 0.0 ? times(1.0 / length, chord) : Place{};
        return shape;
    }
    const double per_radius = 1.0 / circle->radius;
    shape.leaves = times(per_radius, circle->second);
    const Place end = minus(linear(to), circle->centre);
    const Place normal = cross(shape.leaves, times(-per_radius, circle->first));
    shape.arrives = times(per_radius, cross(normal, end));
    // Along axis k the circle is centre + first cos + second sin: greatest in the direction (first, second), least
    // opposite.
    for (std::size_t k = 0; k < 3; ++k) {
        const double c = circle->first[k];
        const double s = circle->second[k];
        const double most = square_root(c * c + s * s);
        if (!(most > 0.0)) {
            continue;
        }
        for (const double sign : {1.0, -1.0}) {
            if (angle_of(sign * c, sign * s) < circle->turn) {
                const double scale = sign / most;
                Place place = along(along(circle->centre, scale * c, circle->first), scale * s, circle->second);
                place[3] = from[3];
                shape.turns[shape.turn_count] = place;
                ++shape.turn_count;
            }
        }
    }
    return shape;
}

Arc::Kind Arc::begin(const Place& from, const Place& via, const Place& to, double sagitta, double merge) noexcept {
    left_ = made_ = 0;
    const Place u = linear(minus(via, from));
    const Place w = linear(minus(to, from));
    const double uu = dot3(u, u);
    const double ww = dot3(w, w);
    const Place between = minus(u, w);
    const double rest = dot3(between, between);
    to_ = to;
    if (smaller(smaller(uu, ww), rest) == 0.0) {
        return Kind::no_plane;
    }
    // How far the middle is from the line, if it is between the ends.
    if (uu <= ww && rest <= ww) {
        const Place off = along(u, -dot3(u, w) / ww, w);
        if (dot3(off, off) <= sagitta * sagitta) {
            left_ = 1;
            return Kind::line;
        }
    }
    const auto circle = circle_through(from, via, to);
    if (!circle) {
        return Kind::no_plane;  // and the middle one not between
    }
    const double radius = circle->radius;
    if (!(radius <= kWidestArc)) {
        return Kind::too_wide;
    }
    if (2.0 * radius <= 1.1 * merge || larger(uu, ww) <= merge * merge) {
        left_ = 1;
        return Kind::line;
    }
    centre_ = circle->centre;
    first_ = circle->first;
    second_ = circle->second;
    const double whole = circle->turn;
    // Sagitta R (1 − cos(x/2)), at most R x²/8.
    const double longest = smaller(kMostTurn, square_root(8.0 * sagitta / radius));
    double parts = 1.0;
    if (whole > longest) {
        const double wanted = whole / longest;
        parts = static_cast<double>(static_cast<std::uint32_t>(wanted)) + 1.0;
    }
    const SineCosine step = sine_cosine_of_small(whole / parts);
    sine_ = step.sine;
    cosine_ = step.cosine;
    at_sine_ = 0.0;
    at_cosine_ = 1.0;
    turn_from_ = from[3];
    turn_step_ = (to[3] - from[3]) / parts;
    left_ = static_cast<std::uint32_t>(parts);
    return Kind::arc;
}

Place Arc::next() noexcept {
    --left_;
    if (left_ == 0) {
        return to_;
    }
    ++made_;
    const double cosine = at_cosine_ * cosine_ - at_sine_ * sine_;
    at_sine_ = at_sine_ * cosine_ + at_cosine_ * sine_;
    at_cosine_ = cosine;
    Place made = along(along(centre_, at_cosine_, first_), at_sine_, second_);
    made[3] = turn_from_ + turn_step_ * made_;
    return made;
}

}  // namespace sc::trajectory
