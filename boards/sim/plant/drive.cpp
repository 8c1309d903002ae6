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
constexpr std::int64_t kShortestLagNs = 500'000;
constexpr std::int64_t kNsPerMs = 1'000'000;
constexpr double kNsToS = 1e-9;

constexpr std::uint32_t kModeHoming = 6;
constexpr std::uint32_t kModeCsp = 8;
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
    options.negative_limit = axis.travel_min - 0.002;
    options.positive_limit = axis.travel_max + 0.002;
    return options;
}

SimDrive::SimDrive(const SimDriveOptions& options)
    : options_(options),
      objects_(options.node, options.quirks),
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
    run_brake();
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
    watch_sync();
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

/// Without a weight that would fall, the brake is a matter of the power alone.
void SimDrive::run_brake() {
    constexpr std::uint32_t kBrakeBit = 1;
    const bool told = (objects_.get(0x60FE, 2) & kBrakeBit) != 0 && (objects_.get(0x60FE, 1) & kBrakeBit) != 0;
    const bool wanted = told || !states_.powered();
    if (wanted == brake_closed_) {
        brake_at_ns_ = -1;
    } else if (brake_at_ns_ < 0) {
        brake_at_ns_ = t_ns_ + options_.brake_ns;
    }
    if (wanted != brake_closed_ && t_ns_ >= brake_at_ns_) {
        brake_closed_ = wanted;
        brake_at_ns_ = -1;
    }
    servo_.brake(brake_closed_);
}

void SimDrive::watch_sync() {
    constexpr std::uint16_t kSyncErrorCode = 0x8700;
    const std::int64_t period = static_cast<std::int64_t>(objects_.get(0x60C2, 1)) * kNsPerMs;
    const bool counts = options_.quirks.lost_syncs > 0 && sync_ns_ >= 0 && states_.powered() && period > 0;
    // Half a period of tolerance: a SYNC that comes a little late is not lost.
    if (counts && t_ns_ - sync_ns_ >= period * static_cast<std::int64_t>(options_.quirks.lost_syncs) + period / 2) {
        sync_ns_ = -1;
        enter_fault(kSyncErrorCode);
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
    objects_.set(0x1003, 0, 1);
    objects_.set(0x1003, 1, code);
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
        case Homing::to_switch:
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
