// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/path_ends.hpp"

#include "firmware/motion/profile.hpp"
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

std::optional<PathEnds::Point> PathEnds::add(const Place& point, std::uint32_t item) noexcept {
    last_ = {point, item};
    if (!has_point_) {
        has_point_ = true;
        held_ = last_;
        return std::nullopt;
    }
    const double step = apart(point, held_.place);
    if (!(step > 0.0) || step < merge_) {
        return std::nullopt;
    }
    Point given = held_;
    before_ = held_;
    held_ = last_;
    if (!started_) {
        started_ = true;
        const Place direction = direction_of(given.place, point);
        run_in_ = run_up(direction);
        start_ = trajectory::along(given.place, -run_in_, direction);
        given.place = start_;
    }
    return given;
}

std::optional<PathEnds::Point> PathEnds::finish() noexcept {
    if (!started_) {
        return std::nullopt;
    }
    const Place direction = direction_of(before_.place, last_.place);
    run_out_ = run_up(direction);
    last_.place = trajectory::along(last_.place, run_out_, direction);
    finished_ = true;
    return last_;
}

}  // namespace sc::motion
