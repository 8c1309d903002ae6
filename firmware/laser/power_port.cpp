// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/power_port.hpp"

namespace sc::laser {
namespace {

std::int64_t last_trigger(const LaserRun& run) noexcept {
    const std::int64_t last = std::int64_t{run.count} - 1;
    return run.t0_ns + (last * run.period_ns256 + last * (last - 1) / 2 * run.change_ns256) / 256;
}

}  // namespace

std::int64_t PowerPort::lead(const LaserRun& run) const noexcept {
    // In the middle between the triggers where that leaves room for the setup after the last strobe; else as early as
    // it may be.
    const std::int64_t gap = run.t0_ns - last_trigger_ns_;
    const std::int64_t wanted = gap / 2 < kLeadNs ? gap / 2 : kLeadNs;
    const std::int64_t most = run.t0_ns - free_ns_ - setup_ns_;
    const std::int64_t lead = wanted < most ? wanted : most;
    return lead > 0 ? lead : 0;
}

void PowerPort::step(std::span<LaserRun> runs) noexcept {
    for (LaserRun& run : runs) {
        run.latch_ns = 0;
        if (run.power != byte_) {
            const std::int64_t before = lead(run);
            if (before > 0) {
                run.latch_ns = static_cast<std::uint16_t>(before);
                byte_ = run.power;
                free_ns_ = run.t0_ns - before + width_ns_;
            } else {
                run.power = static_cast<std::uint8_t>(byte_ < 0 ? 0 : byte_);
                ++kept_;
            }
        }
        last_trigger_ns_ = last_trigger(run);
    }
}

}  // namespace sc::laser
