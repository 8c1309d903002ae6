// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/path_ends.hpp"

#include "firmware/motion/profile.hpp"
#include "firmware/trajectory/arc.hpp"
#include "firmware/trajectory/place.hpp"
#include "shared/math/scalar.hpp"

namespace sc::motion {
namespace {

using trajectory::Place;

double apart(const Place& a, const Place& b) noexcept { return trajectory::length3(trajectory::minus(a, b)); }

Place direction_of(const Place& from, const Place& to) noexcept {
    const Place step = trajectory::minus(to, from);
    return trajectory::times(1.0 / trajectory::length3(step), step);
}

}  // namespace

void PathEnds::open(double speed, double merge, const trajectory::AxisLimits& limits) noexcept {
    *this = PathEnds{};
    speed_ = speed;
    merge_ = merge;
    limits_ = limits;
    for (std::size_t k = 0; k < 3; ++k) {
        Place axis{};
        axis[k] = 1.0;
        run_out_ = larger(run_out_, run_up(axis));
    }
}

double PathEnds::run_up(const Place& direction) const noexcept {
    TangentLimits along{1e12, 1e15};
    double speed = speed_;
    for (std::size_t k = 0; k < 3; ++k) {
        const double d = absolute(direction[k]);
        if (d > 0.0 && limits_.jerk[k] > 0.0) {
            along.acceleration = smaller(along.acceleration, limits_.acceleration[k] / d);
            along.jerk = smaller(along.jerk, limits_.jerk[k] / d);
            speed = smaller(speed, limits_.speed[k] / d);
        }
    }
    return change_distance(0.0, speed, along);
}

/// The path leaves its first point in this direction.
void PathEnds::begin(const Place& direction) noexcept {
    started_ = true;
    run_in_ = run_up(direction);
    start_ = trajectory::along(held_.place, -run_in_, direction);
}

void PathEnds::add(const Point& point, Points& given) noexcept {
    last_ = point;
    if (!has_point_) {
        has_point_ = true;
        held_ = point;
        return;
    }
    if (point.arc) {
        const trajectory::ArcShape shape = trajectory::arc_shape(held_.place, point.via, point.place);
        if (!started_) {
            begin(shape.leaves);
            given.push({.place = start_, .item = held_.item});
        }
        if (!given_) {
            given.push(held_);
        }
        given.push(point);
        held_ = point;
        given_ = true;
        arrives_ = shape.arrives;
        return;
    }
    const double step = apart(point.place, held_.place);
    if (!(step > 0.0) || step < merge_) {
        return;
    }
    if (!started_) {
        begin(direction_of(held_.place, point.place));
        given.push({.place = start_, .item = held_.item});
    } else if (!given_) {
        given.push(held_);
    }
    before_ = held_.place;
    held_ = point;
    given_ = false;
}

void PathEnds::finish(Points& given) noexcept {
    if (!started_) {
        return;
    }
    const Place direction = given_ ? arrives_ : direction_of(before_, last_.place);
    run_out_ = run_up(direction);
    last_.place = trajectory::along(last_.place, run_out_, direction);
    last_.arc = false;
    finished_ = true;
    given.push(last_);
}

}  // namespace sc::motion
