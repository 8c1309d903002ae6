// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/hal/io.hpp"

namespace sc::safety {

/// Compares the beam's shutter with what it was told. It may take its time on the way; what lasts longer, and a shutter
/// that leaves its place untold, is wrong. Control tick context, a few comparisons.
class ShutterWatch {
public:
    constexpr ShutterWatch(std::int64_t time_ns, std::int64_t period_ns) noexcept
        : time_ns_(time_ns), period_ns_(period_ns) {}

    /// Once a tick: the command that was in force until now, and the switches as they read. True: the shutter is not
    /// where it should be.
    [[nodiscard]] constexpr bool wrong(bool open, const DigitalInputs& in) noexcept {
        if (open != open_) {
            open_ = open;
            settled_ = false;
            disagrees_ns_ = 0;
        }
        agrees_ = in.shutter_open == open && in.shutter_closed == !open;
        if (agrees_) {
            settled_ = true;
            disagrees_ns_ = 0;
            return false;
        }
        if (!settled_ && disagrees_ns_ < time_ns_) {
            disagrees_ns_ += period_ns_;
            return false;
        }
        return true;
    }
    /// The beam's way is open, by command and by both switches.
    [[nodiscard]] constexpr bool proven_open() const noexcept { return open_ && agrees_; }
    [[nodiscard]] constexpr bool agrees() const noexcept { return agrees_; }

private:
    std::int64_t time_ns_;
    std::int64_t period_ns_;
    std::int64_t disagrees_ns_ = 0;
    bool open_ = false;
    bool settled_ = false;  ///< has been where it was sent since the command changed
    bool agrees_ = false;
};

}  // namespace sc::safety
