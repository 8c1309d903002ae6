// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "firmware/motion/profile.hpp"
#include "firmware/trajectory/spec.hpp"

namespace sc::motion {

using trajectory::AxisLimits;
using trajectory::Place;

/// One straight dark move from rest to rest within the axes' limits: travel, retract, turn, jog, galvo jump. Closed
/// form, so it needs no plan step: begin() costs some 4 000 operations at worst.
class Move {
public:
    /// From a place to another. A move of no length is done at once. `speed` further limits the path speed (base units
    /// / s).
    void begin(const Place& from, const Place& to, const AxisLimits& limits, double speed) noexcept;
    /// Where the move is at `t` seconds after its begin; its end place from then on.
    [[nodiscard]] Place at(double t) const noexcept;
    [[nodiscard]] double speed(double t) const noexcept;
    /// Comes to rest as soon as the limits allow, on the line. Ends where it stops. A move that is braking already just
    /// ends.
    void stop(double t) noexcept;
    [[nodiscard]] bool done(double t) const noexcept { return t >= end_; }
    [[nodiscard]] double duration() const noexcept { return end_; }

private:
    /// A stretch of constant jerk; way and its derivatives at its begin.
    struct Stretch {
        double t0 = 0.0;
        double duration = 0.0;
        double way0 = 0.0;
        double v0 = 0.0;
        double a0 = 0.0;
        double j = 0.0;

        [[nodiscard]] double end() const noexcept { return t0 + duration; }
        [[nodiscard]] double way(double t) const noexcept {
            const double dt = t - t0;
            return way0 + dt * (v0 + dt * (0.5 * a0 + dt * ((1.0 / 6.0) * j)));
        }
        [[nodiscard]] double speed(double t) const noexcept {
            const double dt = t - t0;
            return v0 + dt * (a0 + dt * (0.5 * j));
        }
        [[nodiscard]] double acceleration(double t) const noexcept { return a0 + (t - t0) * j; }
    };

    void append(const PhaseList& phases, double t, double way, double v) noexcept;
    [[nodiscard]] std::size_t find(double t) const noexcept;
    [[nodiscard]] Place place(double way) const noexcept;

    Place from_{};
    Place direction_{};
    TangentLimits limits_;
    std::array<Stretch, 12> stretch_{};
    std::size_t count_ = 0;
    double end_ = 0.0;
    Place end_place_{};
};

}  // namespace sc::motion
