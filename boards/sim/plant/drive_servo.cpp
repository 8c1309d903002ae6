// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/drive_servo.hpp"

#include <algorithm>
#include <cmath>

#include "shared/units/quantity.hpp"

namespace sc::sim {
namespace {

/// Length of the creep of a homing, as a time at creep speed.
constexpr double kCreepTime = 0.2;
/// An obstacle gives way by a tenth: its stiffness is nine times the loop's.
constexpr double kObstacleStiffness = 9.0;
constexpr double kObstacleDamping = 4.0;

/// Takes `amount` from the magnitude of `value`, but not through zero.
double towards_zero(double value, double amount) noexcept {
    return std::copysign(std::max(std::abs(value) - amount, 0.0), value);
}

}  // namespace

void Trajectory::hold(double position) noexcept {
    kind_ = Kind::hold;
    position_ = position;
    velocity_ = 0.0;
    history_ = false;
}

void Trajectory::follow(double target, double duration_s) noexcept {
    if (!history_) {
        last_target_ = position_;
        before_last_target_ = position_;
        history_ = true;
    }
    kind_ = Kind::spline;
    start_ = position_;
    start_velocity_ = velocity_;
    end_ = target;
    end_velocity_ = (3.0 * target - 4.0 * last_target_ + before_last_target_) / (2.0 * duration_s);
    duration_ = duration_s;
    elapsed_ = 0.0;
    before_last_target_ = last_target_;
    last_target_ = target;
}

void Trajectory::ramp_down(double deceleration) noexcept {
    kind_ = Kind::ramp;
    acceleration_ = deceleration;
    history_ = false;
}

void Trajectory::go_to(double goal, double fast, double creep, double acceleration) noexcept {
    kind_ = Kind::search;
    end_ = goal;
    fast_ = fast;
    creep_ = creep;
    acceleration_ = acceleration;
    history_ = false;
}

void Trajectory::advance(double dt_s) noexcept {
    switch (kind_) {
        case Kind::hold: break;
        case Kind::spline: advance_spline(dt_s); break;
        case Kind::ramp: advance_ramp(dt_s); break;
        case Kind::search: advance_search(dt_s); break;
    }
}

void Trajectory::advance_spline(double dt_s) noexcept {
    elapsed_ += dt_s;
    const double u = elapsed_ / duration_;
    // A missing SYNC: stay at the last target. The tolerance keeps a step that ends on the border inside.
    if (u > 1.0 + 1e-9) {
        position_ = end_;
        velocity_ = 0.0;
        return;
    }
    const double d0 = start_velocity_ * duration_;
    const double d1 = end_velocity_ * duration_;
    const double way = end_ - start_;
    const double c2 = 3.0 * way - 2.0 * d0 - d1;
    const double c3 = d0 + d1 - 2.0 * way;
    position_ = start_ + u * (d0 + u * (c2 + u * c3));
    velocity_ = (d0 + u * (2.0 * c2 + u * 3.0 * c3)) / duration_;
}

void Trajectory::advance_ramp(double dt_s) noexcept {
    const double before = velocity_;
    velocity_ = towards_zero(velocity_, acceleration_ * dt_s);
    position_ += 0.5 * (before + velocity_) * dt_s;
    if (velocity_ == 0.0) {
        hold(position_);
    }
}

void Trajectory::advance_search(double dt_s) noexcept {
    const double way = end_ - position_;
    const double left = std::abs(way);
    const double brake_way = std::max(left - creep_ * kCreepTime, 0.0);
    const double braking = std::sqrt(creep_ * creep_ + 2.0 * acceleration_ * brake_way);
    const double speed = std::min({std::abs(velocity_) + acceleration_ * dt_s, fast_, braking});
    if (speed * dt_s >= left) {
        hold(end_);
        return;
    }
    velocity_ = std::copysign(speed, way);
    position_ += velocity_ * dt_s;
}

Servo::Servo(const ServoOptions& options, double position) noexcept
    : options_(options),
      stiffness_(2.0 / (options.lag_s * options.lag_s)),
      damping_(2.0 / options.lag_s),
      position_(position),
      zero_(position) {
    const double omega = 2.0 * kPi * options.disturbance_frequency;
    push_ = options.disturbance * std::hypot(stiffness_ - omega * omega, damping_ * omega);
}

std::int64_t Servo::counts_at(double position) const noexcept {
    return std::llround((position - zero_) * options_.counts_per_unit);
}
std::int64_t Servo::counts() const noexcept { return frozen_ ? frozen_counts_ : counts_at(position_); }
double Servo::place_of(std::int64_t counts) const noexcept {
    return zero_ + static_cast<double>(counts) / options_.counts_per_unit;
}
double Servo::measured() const noexcept { return place_of(counts()); }

void Servo::set_counts_at(double position, std::int64_t counts) noexcept {
    zero_ = position - static_cast<double>(counts) / options_.counts_per_unit;
}

void Servo::freeze_encoder(bool on) noexcept {
    frozen_counts_ = counts();
    frozen_ = on;
}

void Servo::block(bool on) noexcept {
    obstacle_ = position_;
    blocked_ = on;
}

double Servo::force(double position, double velocity, double demand) const noexcept {
    double sum = 0.0;
    if (powered_) {
        const double measured_place = place_of(frozen_ ? frozen_counts_ : counts_at(position));
        const double wanted = stiffness_ / damping_ * (demand - measured_place);
        sum += damping_ * (std::clamp(wanted, -options_.speed_limit, options_.speed_limit) - velocity);
    }
    if (blocked_) {
        sum -= kObstacleStiffness * stiffness_ * (position - obstacle_) + kObstacleDamping * damping_ * velocity;
    }
    return sum;
}

void Servo::step(double demand, double dt_s) noexcept {
    // Midpoint rule: an error of first order in the step would already shift the lag by half a step.
    const double half = 0.5 * dt_s;
    const double middle_velocity = velocity_ + half * force(position_, velocity_, demand);
    const double falling = powered_ || braked_ ? 0.0 : -options_.gravity;
    const double acceleration = falling + force(position_ + half * velocity_, middle_velocity, demand);
    // Half way through the step, as the demand is.
    const double omega = 2.0 * kPi * options_.disturbance_frequency;
    const double pushed = disturbed_ && push_ > 0.0 ? push_ * std::sin(omega * (phase_ + half)) : 0.0;
    phase_ += dt_s;
    const double friction = options_.friction + (braked_ ? options_.brake : 0.0);
    const double before = velocity_;
    velocity_ = towards_zero(velocity_ + dt_s * (acceleration + pushed), friction * dt_s);
    position_ += 0.5 * (before + velocity_) * dt_s;
}

}  // namespace sc::sim
