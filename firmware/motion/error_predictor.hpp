// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace sc::motion {

/// What an axis is off its path, ahead of the last sample: error, its speed and its acceleration, by a Kalman filter in
/// its steady state. Model and gains follow from two figures, the encoder's grid q and the bandwidth f of the error:
///
///     The error is taken to be spread evenly over 0 … f, ω = 2πf, with the mean square A²/2 of a swing of amplitude A.
///     Then the mean squares of its speed, acceleration and jerk are A²/2 times ω²/3, ω⁴/5 and ω⁶/7, and the jerk goes
///     with the speed, E[j v] = −E[a²]: the best guess of it is j = −Ω² v, Ω² = (1/5)/(1/3) ω² = 0.6 ω². So
///         e' = v,  v' = a,  a' = −Ω² v + w.
///     What this leaves of the jerk, w, has the mean square A²/2 · ω⁶ (1/7 − 3/25) = A²/2 · ω⁶ · 4/175 and is alike
///     over one swing, 1/f. White noise of the same density, drawn once a sample T: A²/2 · ω⁶ · 4/175 / (f T). The
///     samples lie on the grid: variance q²/12, white.
///
/// Riccati's equation is run with them until it stands; no libm, the same bits everywhere. Against "the acceleration
/// stays" (Ω = 0) this halves what is left over of a swing at f, and costs nothing below f/2.
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

    /// A sample, `elapsed_s` after the one before, 20 ms at most. Servo context, 40 operations.
    void sample(double error, double elapsed_s) noexcept;
    /// The first of a new row.
    void restart(double error) noexcept { state_ = {error, 0.0, 0.0}; }

    /// `ahead_s`: 20 ms at most.
    [[nodiscard]] double error(double ahead_s) const noexcept {
        const Way way = way_of(ahead_s);
        return state_[0] + (way.once * state_[1] + way.twice * state_[2]);
    }
    [[nodiscard]] double speed(double ahead_s) const noexcept {
        const Way way = way_of(ahead_s);
        return way.cosine * state_[1] + way.once * state_[2];
    }
    /// Of place, speed and acceleration, per unit of what a sample says more than was predicted.
    [[nodiscard]] const std::array<double, 3>& gains() const noexcept { return gain_; }

private:
    /// sin(Ωh)/Ω, (1 − cos(Ωh))/Ω² and cos(Ωh), by their series: 1e-9 of them up to Ωh = 1.
    struct Way {
        double once = 0.0;
        double twice = 0.0;
        double cosine = 1.0;
    };
    [[nodiscard]] Way way_of(double h) const noexcept {
        const double y = h * h * swing2_;
        const double once =
            h *
            (1.0 - y * (1.0 / 6.0) * (1.0 - y * (1.0 / 20.0) * (1.0 - y * (1.0 / 42.0) * (1.0 - y * (1.0 / 72.0)))));
        const double twice =
            0.5 * h * h *
            (1.0 - y * (1.0 / 12.0) * (1.0 - y * (1.0 / 30.0) * (1.0 - y * (1.0 / 56.0) * (1.0 - y * (1.0 / 90.0)))));
        return {once, twice, 1.0 - swing2_ * twice};
    }

    double swing2_ = 0.0;  ///< Ω²
    std::array<double, 3> state_{};
    std::array<double, 3> gain_{};
};

}  // namespace sc::motion
