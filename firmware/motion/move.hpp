// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "firmware/motion/element.hpp"
#include "firmware/motion/time_law.hpp"

namespace sc::motion {

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
    void append(const PhaseList& phases, double t, double tau, double v) noexcept;
    [[nodiscard]] std::size_t find(double t) const noexcept;

    Element line_;
    std::array<Piece, 12> piece_{};
    std::size_t count_ = 0;
    double end_ = 0.0;
    Place end_place_{};
};

}  // namespace sc::motion
