// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "firmware/hal/io.hpp"
#include "shared/machine/machine.hpp"

/// The power byte of a type-D source. It stands on eight lines, and the source takes it when the latch rises, so that
/// it changes at one moment: between the last trigger of one run and the first of the next.

namespace sc::laser {

/// Gives each run that needs another byte than the one in force its strobe. Servo context, some 30 instructions a run.
class PowerPort {
public:
    /// The latch rises no earlier than this before the run that wants its byte.
    static constexpr std::int64_t kLeadNs = 10'000;

    explicit PowerPort(const LaserConfig& config) noexcept
        : setup_ns_(config.latch_setup_ns), width_ns_(config.latch_width_ns) {}

    /// The runs of a tick in order of time, which will leave: sets `latch_ns` of each. A run that follows too soon for
    /// a strobe keeps the byte in force, and says so.
    void step(std::span<LaserRun> runs) noexcept;
    /// The source's byte is 0, by ServoOutputs::clear_power.
    void cleared() noexcept { byte_ = 0; }
    /// Queued strobes were dropped: which byte is in force is not known.
    void forget() noexcept { byte_ = kUnknown; }
    /// Runs that could not have their own byte. Monotonic.
    [[nodiscard]] std::uint32_t kept() const noexcept { return kept_; }

private:
    static constexpr std::int32_t kUnknown = -1;
    /// How long before the run its latch rises; 0: there is no room.
    [[nodiscard]] std::int64_t lead(const LaserRun& run) const noexcept;

    std::int64_t setup_ns_;
    std::int64_t width_ns_;
    std::int64_t free_ns_ = 0;          ///< the last strobe is over
    std::int64_t last_trigger_ns_ = 0;  ///< of the runs before
    std::int32_t byte_ = 0;
    std::uint32_t kept_ = 0;
};

}  // namespace sc::laser
