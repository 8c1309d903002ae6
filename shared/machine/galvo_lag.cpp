// SPDX-License-Identifier: Apache-2.0
#include "shared/machine/galvo_lag.hpp"

namespace sc {

int fault_of(const GalvoLag& lag, const GalvoConfig& galvo, std::int64_t frame_period_ns) noexcept {
    constexpr std::int64_t kMostLatency = 1'000'000;
    constexpr double kFurthest = 2.0;
    if (lag.empty()) {
        return 0;
    }
    const double frequency = lag.natural_frequency.si();
    const double stated = galvo.natural_frequency.si();
    const bool known = stated > 0.0;
    const bool latency_near =
        !known || (2 * lag.latency_ns >= galvo.latency_ns && lag.latency_ns <= 2 * galvo.latency_ns);
    if (lag.latency_ns < 0 || lag.latency_ns > kMostLatency || !latency_near) {
        return 1;
    }
    // Written so that a frequency or damping that is no number fails.
    const bool frequency_near = !known || (frequency * kFurthest >= stated && frequency <= kFurthest * stated);
    if (!(frequency >= 200.0 && frequency <= 20e3) || !frequency_near) {
        return 2;
    }
    if (!(lag.damping >= 0.1 && lag.damping <= 10.0)) {
        return 3;
    }
    const double least =
        galvo_lead(with_lag(galvo, lag), 0).per_velocity + static_cast<double>(frame_period_ns) * 0.5e-9;
    return least <= static_cast<double>(lag.latency_ns) * 1e-9 ? 0 : 4;
}

}  // namespace sc
