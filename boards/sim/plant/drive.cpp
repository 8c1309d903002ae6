// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/drive.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <string>

namespace sc::sim {
namespace {

using State = DriveStates::State;

constexpr std::int64_t kStepNs = 50'000;
constexpr std::int64_t kSettleNs = 20'000'000;
constexpr std::int64_t kShortestLagNs = 500'000;
constexpr std::int64_t kNsPerMs = 1'000'000;
constexpr double kNsToS = 1e-9;

constexpr std::uint32_t kModeHoming = 6;
constexpr std::uint32_t kModeCsp = 8;
constexpr std::uint32_t kMethodHere = 37;
constexpr std::uint16_t kHomingStartBit = 0x10;
constexpr std::uint16_t kStatusReached = 0x0400;
constexpr std::uint16_t kStatusBit12 = 0x1000;
constexpr std::uint16_t kStatusBit13 = 0x2000;
constexpr std::uint16_t kFollowingErrorCode = 0x8611;

}  // namespace

SimDriveOptions drive_options(const AxisConfig& axis, std::int64_t drive_cycle_ns, double initial_position,
                              std::int64_t bus_ns) {
    const std::int64_t lag_ns = axis.latency_ns - drive_cycle_ns - bus_ns;
    if (lag_ns < kShortestLagNs) {
        throw std::invalid_argument("axis latency of " + std::to_string(axis.latency_ns) +
                                    " ns leaves no room for the servo after one drive cycle of " +
                                    std::to_string(drive_cycle_ns) + " ns");
    }
    SimDriveOptions options;
    options.node = axis.drive_node;
    options.initial_position = initial_position;
    options.servo.counts_per_unit = axis.counts_per_unit;
    options.servo.lag_s = static_cast<double>(lag_ns) * kNsToS;
    options.servo.friction = 0.01 * axis.acceleration;
    options.servo.brake = 10.0 * axis.acceleration;
    options.servo.speed_limit = 1.5 * axis.speed;
    options.servo.reference_position = axis.home_position;
    return options;
}

SimDrive::SimDrive(const SimDriveOptions& options)
    : options_(options),
      objects_(options.node),
      servo_(options.servo, options.initial_position),
      demand_(options.initial_position) {
    before_.position = options.initial_position;
    load_ = load_before_ = options.initial_position;
    restart();
}

void SimDrive::step_to(std::int64_t t_ns) {
    if (t_ns <= t_ns_) {
        return;
    }
    before_ = {.t_ns = t_ns_, .position = servo_.position(), .velocity = servo_.velocity()};
    load_before_ = load_;
    while (t_ns_ < t_ns) {
        advance(std::min(kStepNs, t_ns - t_ns_));
        load_ = pushed(load_, servo_.position());
    }
}

double SimDrive::pushed(double load, double motor) const noexcept {
    const double half = 0.5 * options_.backlash;
    return std::clamp(load, motor - half, motor + half);
}

double SimDrive::load_position_at(std::int64_t t_ns) const noexcept {
    return t_ns >= t_ns_ ? load_ : pushed(load_before_, true_position_at(t_ns));
}

double SimDrive::true_position_at(std::int64_t t_ns) const noexcept {
    const std::int64_t span_ns = t_ns_ - before_.t_ns;
    if (t_ns >= t_ns_ || span_ns <= 0) {
        return servo_.position();
    }
    const double span = static_cast<double>(span_ns) * kNsToS;
    const double u = std::max(static_cast<double>(t_ns - before_.t_ns) / static_cast<double>(span_ns), 0.0);
    const double way = servo_.position() - before_.position;
    const double d0 = before_.velocity * span;
    const double d1 = servo_.velocity() * span;
    return before_.position + u * (d0 + u * ((3.0 * way - 2.0 * d0 - d1) + u * (d0 + d1 - 2.0 * way)));
}

void SimDrive::advance(std::int64_t dt_ns) {
    const double dt = static_cast<double>(dt_ns) * kNsToS;
    const double demand_before = demand_.position();
    demand_.advance(dt);
    servo_.disturb(states_.state() == State::operation_enabled && in_mode(kModeCsp));
    servo_.step(0.5 * (demand_before + demand_.position()), dt);
    t_ns_ += dt_ns;
    if (!states_.powered()) {
        demand_.hold(servo_.measured());
    }
    const State before = states_.state();
    if (demand_.at_rest()) {
        states_.ramp_ended();
    }
    on_state_change(before);
    advance_homing(dt_ns);
    watch_following();
    follow_mode();
    advance_communication();
}

void SimDrive::actuate() {
    const auto controlword = static_cast<std::uint16_t>(objects_.get(0x6040));
    const State before = states_.state();
    states_.control(controlword);
    on_state_change(before);
    if (states_.state() != State::operation_enabled) {
        return;
    }
    if (in_mode(kModeHoming)) {
        actuate_homing(controlword);
    } else if (in_mode(kModeCsp)) {
        const double exponent = static_cast<double>(static_cast<std::int8_t>(objects_.get(0x60C2, 2)));
        const double period = static_cast<double>(objects_.get(0x60C2, 1)) * std::pow(10.0, exponent);
        demand_.follow(servo_.place_of(std::bit_cast<std::int32_t>(objects_.get(0x607A))), period);
    }
}

void SimDrive::on_state_change(State before) {
    const State now = states_.state();
    if (now == before) {
        return;
    }
    servo_.power(states_.powered());
    if (now != State::operation_enabled) {
        homing_ = Homing::idle;
    }
    if (now == State::operation_enabled) {
        demand_.hold(servo_.measured());
    } else if (now == State::quick_stop_active) {
        demand_.ramp_down(in_units(objects_.get(0x6085)));
    } else if (before == State::fault) {
        objects_.set(0x603F, 0, 0);
        objects_.set(0x1001, 0, 0);
        send_emergency(0);
    }
}

void SimDrive::follow_mode() {
    const std::uint32_t mode = objects_.get(0x6060);
    if (mode != objects_.get(0x6061)) {
        objects_.set(0x6061, 0, mode);
        homing_ = Homing::idle;
        homing_bit_ = false;
        if (demand_.at_rest() || !states_.powered()) {
            return;
        }
        demand_.ramp_down(in_units(objects_.get(0x6085)));
    }
}

void SimDrive::actuate_homing(std::uint16_t controlword) {
    const bool bit = (controlword & kHomingStartBit) != 0;
    const bool moving = homing_ == Homing::searching || homing_ == Homing::settling;
    if (bit && !homing_bit_) {
        homing_ = Homing::searching;
        if (objects_.get(0x6098) == kMethodHere) {
            options_.servo.reference_position = servo_.position();
        }
        demand_.go_to(options_.servo.reference_position, in_units(objects_.get(0x6099, 1)),
                      in_units(objects_.get(0x6099, 2)), in_units(objects_.get(0x609A)));
    } else if (!bit && moving) {
        homing_ = Homing::broken_off;
        demand_.ramp_down(in_units(objects_.get(0x609A)));
    }
    homing_bit_ = bit;
}

void SimDrive::advance_homing(std::int64_t dt_ns) {
    if (homing_ == Homing::searching && demand_.at_rest()) {
        homing_ = reference_hidden_ ? Homing::failed : Homing::settling;
        settled_ns_ = 0;
    }
    if (homing_ != Homing::settling) {
        return;
    }
    settled_ns_ = std::abs(following_error_counts()) <= 1.0 ? settled_ns_ + dt_ns : 0;
    if (settled_ns_ >= kSettleNs) {
        const double reference = options_.servo.reference_position;
        servo_.set_counts_at(reference, std::bit_cast<std::int32_t>(objects_.get(0x607C)));
        demand_.hold(reference);
        homing_ = Homing::attained;
    }
}

void SimDrive::watch_following() {
    const std::uint32_t window = objects_.get(0x6065);
    const bool apart = states_.state() == State::operation_enabled && window != 0 &&
                       std::abs(following_error_counts()) > static_cast<double>(window);
    if (!apart) {
        error_since_ns_ = -1;
        return;
    }
    error_since_ns_ = error_since_ns_ < 0 ? t_ns_ : error_since_ns_;
    if (t_ns_ - error_since_ns_ >= static_cast<std::int64_t>(objects_.get(0x6066)) * kNsPerMs) {
        enter_fault(kFollowingErrorCode);
    }
}

void SimDrive::raise_fault(std::uint16_t error_code) { enter_fault(error_code); }

void SimDrive::enter_fault(std::uint16_t code) {
    const State before = states_.state();
    if (before == State::fault || before == State::fault_reaction_active) {
        return;
    }
    states_.trip();
    on_state_change(before);
    objects_.set(0x603F, 0, code);
    objects_.set(0x1001, 0, 1);
    send_emergency(code);
    if (code == kFollowingErrorCode) {
        // The loop cannot be trusted with a ramp: power off, brake on.
        servo_.power(false);
        demand_.hold(servo_.measured());
    } else if (states_.state() == State::fault_reaction_active) {
        demand_.ramp_down(in_units(objects_.get(0x6085)));
    }
}

bool SimDrive::in_mode(std::uint32_t mode) const noexcept { return objects_.get(0x6061) == mode; }

double SimDrive::following_error_counts() const noexcept {
    return (demand_.position() - servo_.measured()) * options_.servo.counts_per_unit;
}

double SimDrive::in_units(std::uint32_t counts) const noexcept {
    return static_cast<double>(counts) / options_.servo.counts_per_unit;
}

std::uint16_t SimDrive::statusword() const noexcept {
    const std::uint16_t bits = states_.status_bits();
    const auto with = [bits](unsigned more) { return static_cast<std::uint16_t>(bits | more); };
    if (states_.state() != State::operation_enabled) {
        return bits;
    }
    if (in_mode(kModeCsp)) {
        return with(kStatusBit12 | (error_since_ns_ >= 0 ? kStatusBit13 : 0U));
    }
    switch (homing_) {
        case Homing::searching:
        case Homing::settling: return bits;
        case Homing::attained: return with(kStatusBit12 | kStatusReached);
        case Homing::failed: return with(kStatusBit13 | kStatusReached);
        case Homing::idle:
        case Homing::broken_off: return with(demand_.at_rest() ? kStatusReached : 0U);
    }
    return bits;
}

}  // namespace sc::sim
