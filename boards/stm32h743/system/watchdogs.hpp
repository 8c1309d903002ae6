// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/system/clock_plan.hpp"

namespace sc::stm32h743 {

/// Both watchdogs, fed by the end of a healthy control cycle alone. What happens when it does not come, or not in time:
///
///     since the last feed   0 ........ 0.61 ms ........ 1.57 ms ..... 1.60 ms ................ 10 ms
///     window watchdog       reset at a feed | feed here | warning: outputs off | reset
///     independent watchdog  counts by LSI (32 kHz, 29.7 to 33.6), whatever the other clocks do        reset
///
/// On reset the chip lets go of its pins; the resistors of the wiring table hold the outputs at their safe levels.
class Watchdogs {
public:
    static constexpr std::uint32_t kCounts = 47;        ///< of the window watchdog, from a feed to the reset
    static constexpr std::uint32_t kClosedCounts = 18;  ///< of them without a feed
    static constexpr std::uint32_t kPeriodsUs = 1'000;  ///< of the control cycle

    /// False when the clocks are not those of the plan, which the counts are made for, or LSI does not run: then nobody
    /// may mark. The independent watchdog counts from here, the window watchdog from the first feed. 1 ms at most.
    [[nodiscard]] bool start(const Frequencies& frequencies) noexcept;

    /// At the end of each control cycle. Once not healthy, never again: the next reset is 1.6 ms away. Two writes.
    void feed(bool healthy) noexcept;

    /// In the interrupt of the warning, 34 us before the reset, after the outputs were made safe.
    static void acknowledge_warning_isr() noexcept;

private:
    bool started_ = false;
    bool gave_up_ = false;
};

enum class ResetCause : std::uint8_t {
    power = 0,
    pin = 1,
    software = 2,
    window_watchdog = 3,
    independent_watchdog = 4,
    other = 5
};

/// Of the word of RCC_RSR: the pin falls with every cause, and power beats all.
[[nodiscard]] ResetCause reset_cause(std::uint32_t word) noexcept;
/// Why the chip started; once, since it forgets.
[[nodiscard]] ResetCause take_reset_cause() noexcept;

namespace watchdog_plan {

/// One count of the window watchdog: 4096 cycles of APB3.
inline constexpr double kCountUs = 4096.0 / (kFast.apb_hz / 1e6);
inline constexpr std::uint32_t kLsiHz = 32'000;
inline constexpr std::uint32_t kIndependentCounts = 80;  ///< of LSI / 4

// A cycle that comes 0.35 ms early or 0.5 ms late is healthy; one that is left out is not, nor are two in one. A count
// may be begun when it is loaded.
static_assert((Watchdogs::kClosedCounts + 1) * kCountUs < Watchdogs::kPeriodsUs - 350);
static_assert((Watchdogs::kCounts - 2) * kCountUs > Watchdogs::kPeriodsUs + 500);
static_assert(Watchdogs::kCounts * kCountUs < 2 * Watchdogs::kPeriodsUs - 350);
static_assert(Watchdogs::kCounts <= 64 && Watchdogs::kClosedCounts < Watchdogs::kCounts);
static_assert(kIndependentCounts * 4 * 1'000'000 / kLsiHz == 10'000);

}  // namespace watchdog_plan
}  // namespace sc::stm32h743
