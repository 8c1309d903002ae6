// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/path_builder.hpp"

#include "shared/math/scalar.hpp"

namespace sc::motion {
namespace {

constexpr double kSamePlace = 1e-9;    // m
constexpr double kStraight = 1e-9;     // |d2 − d1| below which two lines are one
constexpr double kSharpest = -0.5;     // cosine of the sharpest corner that is rounded
constexpr double kLargestShare = 0.4;  // of the shorter neighbour that a blend may take
constexpr double kBlendDeviation = 0.1875;

double linear_dot(const Place& a, const Place& b) noexcept { return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]; }

Place along(const Place& from, const Place& direction, double length) noexcept {
    Place p = from;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        p[i] = from[i] + direction[i] * length;
    }
    return p;
}

}  // namespace

void PathBuilder::open(const PathSpec& spec) noexcept {
    *this = PathBuilder{};
    spec_ = spec;
}

void PathBuilder::emit_line(double length, bool stop, ElementRing& ring) noexcept {
    Element line = make_line(line_from_, direction_, length, spec_.speed, spec_.limits);
    line.item = item_;
    line.stop_at_end = stop;
    ring.append(line);
}

void PathBuilder::corner(const Place& direction, double length, ElementRing& ring) noexcept {
    Place difference{};
    for (std::size_t i = 0; i < 3; ++i) {
        difference[i] = direction[i] - direction_[i];
    }
    const double bend = square_root(linear_dot(difference, difference));
    const bool straight = bend < kStraight;
    const bool sharp = linear_dot(direction, direction_) < kSharpest || spec_.tolerance < kSamePlace;
    if (straight || sharp) {
        emit_line(line_length_, !straight, ring);
        line_from_ = vertex_;
        line_length_ = length;
    } else {
        const double half =
            smaller(spec_.tolerance / (kBlendDeviation * bend), kLargestShare * smaller(segment_length_, length));
        emit_line(line_length_ - half, false, ring);
        Element blend =
            make_blend(along(vertex_, direction_, -half), direction_, direction, half, spec_.speed, spec_.limits);
        blend.item = item_;
        ring.append(blend);
        line_from_ = along(vertex_, direction, half);
        line_length_ = length - half;
    }
    direction_ = direction;
    segment_length_ = length;
    item_ = vertex_item_;
}

void PathBuilder::add(const Place& point, std::uint32_t item, ElementRing& ring) noexcept {
    if (!has_point_) {
        has_point_ = true;
        vertex_ = point;
        vertex_item_ = item;
        return;
    }
    Place step{};
    for (std::size_t i = 0; i < 3; ++i) {
        step[i] = point[i] - vertex_[i];
    }
    const double length = square_root(linear_dot(step, step));
    if (length < kSamePlace) {
        return;
    }
    Place direction{};
    for (std::size_t i = 0; i < 3; ++i) {
        direction[i] = step[i] / length;
    }
    if (!has_direction_) {
        const Element probe = make_line(vertex_, direction, length, spec_.speed, spec_.limits);
        run_in_ = change_distance(0.0, probe.cap, probe.limits);
        start_ = along(vertex_, direction, -run_in_);
        has_direction_ = true;
        direction_ = direction;
        line_from_ = start_;
        line_length_ = run_in_ + length;
        segment_length_ = length;
        item_ = vertex_item_;
    } else {
        corner(direction, length, ring);
    }
    vertex_ = point;
    vertex_item_ = item;
}

bool PathBuilder::finish(ElementRing& ring) noexcept {
    if (!has_direction_) {
        return false;
    }
    const Element probe = make_line(line_from_, direction_, line_length_, spec_.speed, spec_.limits);
    const double run_out = change_distance(0.0, probe.cap, probe.limits);
    emit_line(line_length_ + run_out, false, ring);
    mark_end_ = ring.distance() - run_out;
    finished_ = true;
    return true;
}

}  // namespace sc::motion
