// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "shared/math/scalar.hpp"

namespace sc::motion {

/// Takes up the play of one axis: half its width to the side to which the axis last moved. After a reversal the offset
/// crosses the play in a fixed time by three pieces of constant jerk (32·width/T³, its opposite, itself), from rest to
/// rest; a reversal meanwhile waits for the end, so these bounds hold whatever the axis does. Before the first motion
/// the side is unknown and the offset is 0. Servo context: no division, some 20 operations.
class Backlash {
public:
    Backlash() noexcept = default;
    /// `width`, `dead` and `jump` in base units; a reversal by less than `dead` is none, nor is a step of more than
    /// `jump` in one tick a motion. `ticks`: how long a crossing takes.
    Backlash(double width, double dead, double ticks, double jump = 1e300) noexcept
        : half_(0.5 * width), dead_(dead), step_(1.0 / ticks), jump_(jump) {}

    [[nodiscard]] double offset() const noexcept { return offset_; }

    /// The axis is being moved by others (homing): a crossing is over at once, for nobody follows it.
    void settle() noexcept {
        from_ = to_ = offset_ = side_ * half_;
        u_ = 1.0;
    }

    /// Once a tick, with the place that the load is to have.
    void step(double place) noexcept {
        if (!started_) {
            started_ = true;
            extreme_ = last_ = place;
        }
        if (absolute(place - last_) > jump_) {
            extreme_ = place;  // homing has set another zero: nothing has moved
        }
        last_ = place;
        if (place > extreme_ + (side_ > 0.0 ? 0.0 : dead_)) {
            side_ = 1.0;
            extreme_ = place;
        } else if (place < extreme_ - (side_ < 0.0 ? 0.0 : dead_)) {
            side_ = -1.0;
            extreme_ = place;
        }
        if (u_ >= 1.0) {
            if (side_ * half_ == to_) {
                return;
            }
            from_ = to_;
            to_ = side_ * half_;
            u_ = 0.0;
        }
        u_ = u_ + step_;
        offset_ = u_ >= 1.0 ? to_ : from_ + (to_ - from_) * crossed(u_);
    }

private:
    /// 0 to 1: jerk 32, −32, 32 in the quarters 1, 2 to 3, and 4.
    [[nodiscard]] static constexpr double crossed(double u) noexcept {
        constexpr double kSixth = 32.0 / 6.0;
        const double v = u <= 0.5 ? u : 1.0 - u;
        const double w = 0.5 - v;
        const double low = v <= 0.25 ? kSixth * (v * v * v) : (0.5 - 2.0 * w) + kSixth * (w * w * w);
        return u <= 0.5 ? low : 1.0 - low;
    }

    double half_ = 0.0;
    double dead_ = 0.0;
    double step_ = 1.0;
    double jump_ = 1e300;
    double last_ = 0.0;
    bool started_ = false;
    double side_ = 0.0;
    double extreme_ = 0.0;
    double from_ = 0.0;
    double to_ = 0.0;
    double u_ = 1.0;
    double offset_ = 0.0;
};

}  // namespace sc::motion
