// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sc::stm32h743 {

/// Control time within a tick, from TIM5, which counts with the same clock as the galvo's and the gate's timers, so
/// that nothing drifts between them.
class ControlClock {
public:
    static constexpr std::int64_t kCountsPerMs = 240'000;

    /// Counts from `origin_ns`, a multiple of 1 ms. False: the counter does not run.
    [[nodiscard]] bool start(std::int64_t origin_ns) noexcept;
    /// Control time in ns; `tick` is any within 8 s of now. A register read and a division.
    [[nodiscard]] std::int64_t now_ns(std::int64_t tick) const noexcept;
    /// What the counter reads at a control time, cut to a whole count.
    [[nodiscard]] std::uint32_t count_at(std::int64_t ns) const noexcept;
    /// How long ago a control time was, within 8 s.
    [[nodiscard]] std::int64_t since_ns(std::int64_t ns) const noexcept;

private:
    std::int64_t origin_ms_ = 0;
};

}  // namespace sc::stm32h743
