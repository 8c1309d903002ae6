// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace sc::motion {

/// What an axis is off its path, ahead of the last sample: error, its speed and its acceleration, by a Kalman filter in
/// its steady state (an α-β-γ filter) of the model "the acceleration stays".
///
/// The gains follow from two figures. The samples lie on the encoder's grid q: variance q²/12, white. The error is
/// taken to swing with amplitude A at the bandwidth f, ω = 2πf: then its jerk has the variance A²ω⁶/2 and is alike over
/// some 1/ω. White noise of the same density, drawn once a sample T, has the variance A²ω⁶/2 · 2/(ωT) = A²ω⁵/T. With it
/// Riccati's equation is run until it stands; no libm, the same bits everywhere. The error of a prediction by h is then
/// some A(ωh)³/6 and the grid's noise, a place of 0.8 to 1 grid.
class ErrorPredictor {
public:
    struct Design {
        double sample_s = 1e-3;  ///< between samples
        double grid = 1e-6;      ///< of the encoder; the unit of error, amplitude and grid is one and the same
        double amplitude = 50e-6;
        double bandwidth_hz = 20.0;
    };
    ErrorPredictor() noexcept = default;
    /// Some 60 000 operations: at the start, not in a tick.
    explicit ErrorPredictor(const Design& design) noexcept;

    /// A sample, `elapsed_s` after the one before. Servo context, 20 operations.
    void sample(double error, double elapsed_s) noexcept;
    /// The first of a new row.
    void restart(double error) noexcept { state_ = {error, 0.0, 0.0}; }

    [[nodiscard]] double error(double ahead_s) const noexcept {
        return state_[0] + ahead_s * (state_[1] + (0.5 * ahead_s) * state_[2]);
    }
    [[nodiscard]] double speed(double ahead_s) const noexcept { return state_[1] + ahead_s * state_[2]; }
    /// Of place, speed and acceleration, per unit of what a sample says more than was predicted.
    [[nodiscard]] const std::array<double, 3>& gains() const noexcept { return gain_; }

private:
    std::array<double, 3> state_{};
    std::array<double, 3> gain_{};
};

}  // namespace sc::motion
