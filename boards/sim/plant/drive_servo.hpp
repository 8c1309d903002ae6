// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// The mechanical half of a simulated drive: where its demand goes (Trajectory) and how the axis follows (Servo).
/// Base units: metres for a linear axis, degrees for the turntable.

namespace sc::sim {

struct ServoOptions {
    double counts_per_unit = 1e6;
    /// At constant speed the axis is where the demand was so long ago; for smooth motion nearly so: the loop
    /// 1/(1 + τs + τ²s²/2) agrees with a pure delay of τ to second order, the rest is jerk · τ³/6.
    double lag_s = 2e-3;
    double friction = 0.05;           ///< Coulomb, base units / s²
    double brake = 50.0;              ///< deceleration without power, base units / s²
    double speed_limit = 0.3;         ///< of the velocity loop, base units / s
    double reference_position = 0.0;  ///< true place of the reference switch
    /// Without power and with its brake open the axis falls, towards minus; base units / s². In the loop it is
    /// balanced.
    double gravity = 0.0;
    /// A force that swings as a sine while the drive follows targets: the following error, base units, that it would
    /// make in the loop without friction; and its frequency, Hz.
    double disturbance = 0.0;
    double disturbance_frequency = 0.0;
};

/// The demand of the position loop, at one moment.
class Trajectory {
public:
    explicit Trajectory(double position) noexcept : position_(position) {}

    [[nodiscard]] double position() const noexcept { return position_; }
    [[nodiscard]] double velocity() const noexcept { return velocity_; }
    [[nodiscard]] bool at_rest() const noexcept { return kind_ == Kind::hold; }

    /// Stands at a place from now on.
    void hold(double position) noexcept;
    /// CSP: from the present demand to `target` over `duration_s`, by a cubic whose end velocity is that of the
    /// parabola through the last three targets. Also sets off the next target's history.
    void follow(double target, double duration_s) noexcept;
    /// Ramps down to standstill.
    void ramp_down(double deceleration) noexcept;
    /// Homing: fast towards `goal`, the last stretch at `creep`, then stands on it.
    void go_to(double goal, double fast, double creep, double acceleration) noexcept;

    void advance(double dt_s) noexcept;

private:
    enum class Kind : std::uint8_t { hold, spline, ramp, search };
    void advance_spline(double dt_s) noexcept;
    void advance_ramp(double dt_s) noexcept;
    void advance_search(double dt_s) noexcept;

    Kind kind_ = Kind::hold;
    double position_ = 0.0;
    double velocity_ = 0.0;
    double last_target_ = 0.0;
    double before_last_target_ = 0.0;
    bool history_ = false;
    double start_ = 0.0;
    double start_velocity_ = 0.0;
    double end_ = 0.0;
    double end_velocity_ = 0.0;
    double duration_ = 0.0;
    double elapsed_ = 0.0;
    double acceleration_ = 0.0;
    double fast_ = 0.0;
    double creep_ = 0.0;
};

/// The axis: second-order position loop on the encoder's counts, Coulomb friction with sticking, brake.
class Servo {
public:
    Servo(const ServoOptions& options, double position) noexcept;

    [[nodiscard]] double position() const noexcept { return position_; }
    [[nodiscard]] double velocity() const noexcept { return velocity_; }
    /// Encoder, counts from its zero.
    [[nodiscard]] std::int64_t counts() const noexcept;
    /// Encoder as a place.
    [[nodiscard]] double measured() const noexcept;
    [[nodiscard]] double place_of(std::int64_t counts) const noexcept;
    /// Moves the encoder's zero so that the true place `position` reads `counts`.
    void set_counts_at(double position, std::int64_t counts) noexcept;

    /// The brake holds whenever there is no power, unless `brake` is called after.
    void power(bool on) noexcept {
        powered_ = on;
        braked_ = !on;
    }
    void brake(bool closed) noexcept { braked_ = closed; }
    void freeze_encoder(bool on) noexcept;
    void block(bool on) noexcept;
    /// The force of the disturbance acts.
    void disturb(bool on) noexcept { disturbed_ = on; }

    /// One step of at most 50 µs, with the demand half way through it.
    void step(double demand, double dt_s) noexcept;

private:
    [[nodiscard]] std::int64_t counts_at(double position) const noexcept;
    [[nodiscard]] double force(double position, double velocity, double demand) const noexcept;

    ServoOptions options_;
    double stiffness_ = 0.0;
    double damping_ = 0.0;
    double position_ = 0.0;
    double velocity_ = 0.0;
    double zero_ = 0.0;
    double obstacle_ = 0.0;
    std::int64_t frozen_counts_ = 0;
    double push_ = 0.0;   ///< greatest force of the disturbance, base units / s²
    double phase_ = 0.0;  ///< s since the start, of its sine
    bool disturbed_ = false;
    bool frozen_ = false;
    bool blocked_ = false;
    bool powered_ = false;
    bool braked_ = true;
};

}  // namespace sc::sim
