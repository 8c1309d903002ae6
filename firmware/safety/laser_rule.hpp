// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/safety/transitions.hpp"
#include "shared/units/quantity.hpp"

/// When a pulse may leave. One pure rule, asked for every window of pulses; the frame guard and the board's hardware
/// can only take away from its answer.

namespace sc::safety {

/// All that the rule looks at. The default forbids.
struct MarkContext {
    State state = State::boot;
    bool mark_segment = false;       ///< the path distance lies between first and last pulse
    bool mo_ready = false;           ///< the master oscillator's wait is over
    bool interlocks_closed = false;  ///< e-stop chain and interlock
    bool laser_healthy = false;      ///< source ready, no alarm
    bool galvo_healthy = false;
    bool shutter_open = false;                 ///< proven by its read-back
    bool key_production = false;               ///< the key stands at production
    std::uint64_t faults = ~std::uint64_t{0};  ///< latched
    Speed path_speed;
    Speed path_speed_min;
};

/// True only if every condition holds; a speed that is not a number forbids. Any context, a few comparisons.
[[nodiscard]] constexpr bool gate_permitted(const MarkContext& c) noexcept {
    return gate_state(c.state) && c.mark_segment && c.mo_ready && c.interlocks_closed && c.laser_healthy &&
           c.galvo_healthy && c.shutter_open && c.key_production && c.faults == 0 && c.path_speed >= c.path_speed_min;
}

/// Master oscillator: on in the states that want it, ready once it has been on for its wait without a break.
class MoSequencer {
public:
    constexpr MoSequencer(std::int64_t wait_ns, std::int64_t period_ns) noexcept
        : wait_ns_(wait_ns), period_ns_(period_ns) {}

    /// Once a control tick, with the state that holds in this tick. `permitted` false keeps it off in any state.
    constexpr void step(State state, bool permitted = true) noexcept {
        const bool wanted = mo_state(state) && permitted;
        if (wanted && on_ && on_ns_ < wait_ns_) {
            on_ns_ += period_ns_;
        } else if (!wanted || !on_) {
            on_ns_ = 0;
        }
        on_ = wanted;
    }
    [[nodiscard]] constexpr bool on() const noexcept { return on_; }
    [[nodiscard]] constexpr bool ready() const noexcept { return on_ && on_ns_ >= wait_ns_; }

private:
    std::int64_t wait_ns_;
    std::int64_t period_ns_;
    std::int64_t on_ns_ = 0;
    bool on_ = false;
};

}  // namespace sc::safety
