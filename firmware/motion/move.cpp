// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/move.hpp"

#include "shared/math/scalar.hpp"

namespace sc::motion {

void Move::begin(const Place& from, const Place& to, const AxisLimits& limits, double speed) noexcept {
    count_ = 0;
    end_ = 0.0;
    end_place_ = to;
    Place d{};
    double sum = 0.0;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        d[i] = to[i] - from[i];
        sum = sum + d[i] * d[i];
    }
    const double length = square_root(sum);
    if (length < 1e-12) {
        return;
    }
    for (double& v : d) {
        v = v / length;
    }
    from_ = from;
    direction_ = d;
    limits_ = {1e30, 1e30};
    double cap = speed;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const double share = absolute(d[i]);
        if (share > 1e-12) {
            cap = smaller(cap, limits.speed[i] / share);
            limits_.acceleration = smaller(limits_.acceleration, limits.acceleration[i] / share);
            limits_.jerk = smaller(limits_.jerk, limits.jerk[i] / share);
        }
    }
    append(fastest_profile(0.0, 0.0, cap, length, limits_), 0.0, 0.0, 0.0);
}

void Move::append(const PhaseList& phases, double t, double way, double v) noexcept {
    for (std::size_t i = 0; i < phases.count && count_ < stretch_.size(); ++i) {
        Stretch piece;
        piece.t0 = t;
        piece.duration = phases.phase[i].duration;
        piece.way0 = way;
        piece.v0 = v;
        piece.a0 = phases.phase[i].start_acceleration;
        piece.j = phases.phase[i].jerk;
        t = piece.end();
        way = piece.way(t);
        v = piece.speed(t);
        stretch_[count_] = piece;
        ++count_;
    }
    end_ = t;
}

std::size_t Move::find(double t) const noexcept {
    std::size_t k = 0;
    while (k + 1 < count_ && stretch_[k].end() <= t) {
        ++k;
    }
    return k;
}

Place Move::place(double way) const noexcept {
    Place p = from_;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        p[i] = p[i] + direction_[i] * way;
    }
    return p;
}

Place Move::at(double t) const noexcept {
    if (count_ == 0 || done(t)) {
        return end_place_;
    }
    return place(stretch_[find(t)].way(t));
}

double Move::speed(double t) const noexcept { return count_ == 0 || done(t) ? 0.0 : stretch_[find(t)].speed(t); }

void Move::stop(double t) noexcept {
    if (count_ == 0 || done(t)) {
        return;
    }
    const std::size_t k = find(t);
    const double a = stretch_[k].acceleration(t);
    if (a < -1e-9) {
        return;
    }
    double way = stretch_[k].way(t);
    double v = stretch_[k].speed(t);
    count_ = k + 1;
    stretch_[k].duration = t - stretch_[k].t0;
    PhaseList phases;
    if (a > 1e-9) {
        phases.add(a / limits_.jerk, -limits_.jerk, a);
        append(phases, t, way, v);
        const Stretch& ramp = stretch_[count_ - 1];
        t = ramp.end();
        way = ramp.way(t);
        v = ramp.speed(t);
    }
    PhaseList braking;
    braking.add_change(v, 0.0, limits_);
    append(braking, t, way, v);
    const Stretch& last = stretch_[count_ - 1];
    end_place_ = place(last.way(last.end()));
}

}  // namespace sc::motion
