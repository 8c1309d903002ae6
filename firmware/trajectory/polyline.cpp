// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/polyline.hpp"

#include "firmware/trajectory/place.hpp"
#include "shared/math/scalar.hpp"

namespace sc::trajectory {
namespace {

constexpr double kAbsorbed = 0.05;  ///< of the tolerance

}  // namespace

void Polyline::open(const Limits& limits) noexcept {
    points_.clear();
    merge_ = limits.merge;
    corner_cosine_ = limits.corner_cosine;
    closed_ = false;
}

void Polyline::add(const Place& place, std::uint32_t item) noexcept {
    const std::uint32_t n = points_.end();
    double s = 0.0;
    bool corner = true;
    if (n > 0) {
        Vertex& last = points_[n - 1];
        const Place step = minus(place, last.p);
        const double long_step = length(step);
        if (!(long_step > merge_)) {
            return;
        }
        s = last.s + long_step;
        if (n > 1) {
            const Place before = minus(last.p, points_[n - 2].p);
            last.corner = dot(before, step) < corner_cosine_ * (length(before) * long_step);
        }
        corner = false;
    }
    points_.push() = {place, s, 0.0, item, corner};
}

void Polyline::close() noexcept {
    closed_ = true;
    if (points_.size() > 0) {
        points_[points_.end() - 1].corner = true;
    }
}

bool Polyline::straight(std::uint32_t from, std::uint32_t to, double most) const noexcept {
    const Place& a = points_[from].p;
    const Place chord = minus(points_[to].p, a);
    const double square = dot(chord, chord);
    for (std::uint32_t i = from + 1; i < to; ++i) {
        const Place r = minus(points_[i].p, a);
        const double t = clamped(dot(r, chord) / square, 0.0, 1.0);
        const Place off = along(r, -t, chord);
        if (dot(off, off) > most * most) {
            return false;
        }
    }
    return square > 0.0;
}

bool Polyline::stub(std::uint32_t at, bool forward, const Limits& limits, Stub& found) const noexcept {
    const double s0 = points_[at].s;
    const auto next = [&](std::uint32_t i) noexcept { return forward ? i + 1 : i - 1; };
    const auto reach = [&](std::uint32_t i) noexcept { return absolute(points_[i].s - s0); };
    const auto chord = [&](std::uint32_t i) noexcept {
        return forward ? straight(at, i, kAbsorbed * limits.tolerance) : straight(i, at, kAbsorbed * limits.tolerance);
    };
    // How far to look: to the next corner, or as far as is of use.
    std::uint32_t stop = next(at);
    for (std::uint32_t n = 1;; ++n) {
        if (forward && stop >= known()) {
            return false;
        }
        if (points_[stop].corner || reach(stop) >= limits.stub || n >= kStubPoints) {
            break;
        }
        stop = next(stop);
    }
    const std::uint32_t first = next(at);
    std::uint32_t best = first;
    // Absorbing the head of a curve may have straightened it; it stays a curve.
    found.whole = forward && points_[stop].corner && (stop == first || (reach(stop) < limits.stub && chord(stop)));
    if (found.whole) {
        best = stop;
    } else {
        // With the other corner in sight each side takes its half at most, so that the two do not meet.
        const double most = points_[stop].corner ? 0.5 * reach(stop) : limits.stub;
        for (std::uint32_t i = first; i != stop && reach(next(i)) <= most && chord(next(i)); i = next(i)) {
            best = next(i);
        }
    }
    found.point = best;
    found.length = reach(best);
    const Place step = forward ? minus(points_[best].p, points_[at].p) : minus(points_[at].p, points_[best].p);
    found.direction = times(1.0 / found.length, step);
    return true;
}

void Polyline::absorb(std::uint32_t at, const Stub& stub, bool forward) noexcept {
    const std::uint32_t from = forward ? at : stub.point;
    const std::uint32_t to = forward ? stub.point : at;
    const Vertex& origin = points_[from];
    for (std::uint32_t i = from + 1; i < to; ++i) {
        points_[i].p = along(origin.p, points_[i].s - origin.s, stub.direction);
    }
}

Place Polyline::at(double s, std::uint32_t low, std::uint32_t high, std::uint32_t& hint) const noexcept {
    std::uint32_t i = hint < low ? low : (hint >= high ? high - 1 : hint);
    while (i > low && points_[i].s > s) {
        --i;
    }
    while (i + 1 < high && points_[i + 1].s <= s) {
        ++i;
    }
    hint = i;
    const Vertex& a = points_[i];
    const Vertex& b = points_[i + 1];
    return along(a.p, (s - a.s) / (b.s - a.s), minus(b.p, a.p));
}

}  // namespace sc::trajectory
