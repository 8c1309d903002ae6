// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "boards/linux_rt/control_loop.hpp"
#include "boards/linux_rt/pacer.hpp"

namespace sc::linux_rt {

enum class Pace : std::uint8_t {
    time,    ///< the clock alone; a drive that does not answer in its time is late
    drives,  ///< the clock, and no tick before drives and event device have answered the last: for a machine in which
             ///< time means nothing
};

struct RunnerOptions {
    Pace pace = Pace::time;
    std::int64_t answer_timeout_ns = 1'000'000'000;  ///< Pace::drives: for so long a tick waits
    std::uint64_t most_overruns = 20;                ///< Pace::time: so many in a row end the run; 0: any number
};

enum class RunEnd : std::uint8_t { stopped, overruns, not_stopped };

/// The loop at its pace until it is asked to stop, in the calling thread, which allocates nothing meanwhile. Asked, it
/// brings the axes to rest and off (for three seconds at most) and makes the outputs safe.
class Runner {
public:
    Runner(ControlLoop& loop, DriveBus& drives, Clock& clock, std::int64_t period_ns, const RunnerOptions& options)
        : loop_(&loop), drives_(&drives), clock_(&clock), options_(options), pacer_(clock, period_ns) {}

    RunEnd run(const std::atomic<bool>& stop);

    [[nodiscard]] const Pacer& pacer() const noexcept { return pacer_; }
    /// Of any thread.
    [[nodiscard]] std::int64_t ticks() const noexcept { return ticks_.load(std::memory_order_relaxed); }
    [[nodiscard]] std::uint64_t allocations() const noexcept { return allocations_.load(std::memory_order_relaxed); }

private:
    void wait_for_answers();

    ControlLoop* loop_;
    DriveBus* drives_;
    Clock* clock_;
    RunnerOptions options_;
    Pacer pacer_;
    std::atomic<std::int64_t> ticks_{0};
    std::atomic<std::uint64_t> allocations_{0};
};

}  // namespace sc::linux_rt
