// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "shared/machine/machine.hpp"
#include "shared/units/quantity.hpp"

namespace sc {

/// How the mirrors follow, as burnt lines have shown it, in place of what GalvoConfig states. Same meanings as there.
struct GalvoLag {
    std::int64_t latency_ns = 0;
    Frequency natural_frequency;
    double damping = 0.0;

    /// Nothing was measured: the machine's own figures hold.
    [[nodiscard]] constexpr bool empty() const noexcept {
        return latency_ns == 0 && natural_frequency.si() == 0.0 && damping == 0.0;
    }
    constexpr bool operator==(const GalvoLag&) const noexcept = default;
};

[[nodiscard]] constexpr GalvoLag lag_of(const GalvoConfig& galvo) noexcept {
    return {galvo.latency_ns, galvo.natural_frequency, galvo.damping};
}
[[nodiscard]] constexpr GalvoConfig with_lag(GalvoConfig galvo, const GalvoLag& lag) noexcept {
    galvo.latency_ns = lag.latency_ns;
    galvo.natural_frequency = lag.natural_frequency;
    galvo.damping = lag.damping;
    return galvo;
}

/// What may be laid in a head's frames: a frequency of 200 Hz to 20 kHz, a damping of 0.1 to 10, a latency of 1 ms at
/// most that holds half a frame and the servo's lag, and, where the machine states a servo, latency and frequency from
/// half to twice what it states (a lag further off is another head's, or a mistake). An empty one may always.
/// 0: sound; else what is not, 1 latency, 2 frequency, 3 damping, 4 a latency below half a frame and the servo's lag.
[[nodiscard]] int fault_of(const GalvoLag& lag, const GalvoConfig& galvo, std::int64_t frame_period_ns) noexcept;
[[nodiscard]] inline bool sound(const GalvoLag& lag, const GalvoConfig& galvo, std::int64_t frame_period_ns) noexcept {
    return fault_of(lag, galvo, frame_period_ns) == 0;
}

}  // namespace sc
