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
    line_ = make_line(from, d, length, speed, limits);
    append(fastest_profile(0.0, 0.0, line_.cap, length, line_.limits), 0.0, 0.0, 0.0);
}

void Move::append(const PhaseList& phases, double t, double tau, double v) noexcept {
    for (std::size_t i = 0; i < phases.count && count_ < piece_.size(); ++i) {
        Piece piece;
        piece.t0 = t;
        piece.duration = phases.phase[i].duration;
        piece.tau0 = tau;
        piece.v0 = v;
        piece.a0 = phases.phase[i].start_acceleration;
        piece.j = phases.phase[i].jerk;
        t = piece.end();
        tau = piece.tau(t);
        v = piece.speed(t);
        piece_[count_] = piece;
        ++count_;
    }
    end_ = t;
}

std::size_t Move::find(double t) const noexcept {
    std::size_t k = 0;
    while (k + 1 < count_ && piece_[k].end() <= t) {
        ++k;
    }
    return k;
}

Place Move::at(double t) const noexcept {
    if (count_ == 0 || done(t)) {
        return end_place_;
    }
    return line_.place(piece_[find(t)].tau(t));
}

double Move::speed(double t) const noexcept { return count_ == 0 || done(t) ? 0.0 : piece_[find(t)].speed(t); }

void Move::stop(double t) noexcept {
    if (count_ == 0 || done(t)) {
        return;
    }
    const std::size_t k = find(t);
    const double a = piece_[k].acceleration(t);
    if (a < -1e-9) {
        return;
    }
    double tau = piece_[k].tau(t);
    double v = piece_[k].speed(t);
    count_ = k + 1;
    piece_[k].duration = t - piece_[k].t0;
    PhaseList phases;
    if (a > 1e-9) {
        phases.add(a / line_.limits.jerk, -line_.limits.jerk, a);
        append(phases, t, tau, v);
        const Piece& ramp = piece_[count_ - 1];
        t = ramp.end();
        tau = ramp.tau(t);
        v = ramp.speed(t);
    }
    PhaseList braking;
    braking.add_change(v, 0.0, line_.limits);
    append(braking, t, tau, v);
    const Piece& last = piece_[count_ - 1];
    end_place_ = line_.place(last.tau(last.end()));
}

}  // namespace sc::motion
