// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "boards/linux_rt/histogram.hpp"

namespace sc::linux_rt {

/// A monotonic clock and a sleep to a time of it.
class Clock {
public:
    Clock() = default;
    Clock(const Clock&) = delete;
    Clock& operator=(const Clock&) = delete;
    virtual ~Clock() = default;
    [[nodiscard]] virtual std::int64_t now_ns() noexcept = 0;
    virtual void sleep_until(std::int64_t ns) noexcept = 0;
};

/// CLOCK_MONOTONIC, absolute sleep; a signal does not shorten it.
class SystemClock final : public Clock {
public:
    [[nodiscard]] std::int64_t now_ns() noexcept override;
    void sleep_until(std::int64_t ns) noexcept override;
};

/// Keeps the control period, and counts how well. `begin` once, then `wait` before each tick and `done` after it.
///
/// Late: the tick began after its time (histogram). Overrun: it began a whole period or more after its time, so its
/// SYNC came a period late; the schedule then goes on from there, since ticks that are missing cannot be made up.
class Pacer {
public:
    Pacer(Clock& clock, std::int64_t period_ns) noexcept : clock_(&clock), period_ns_(period_ns) {}

    void begin() noexcept { next_ns_ = clock_->now_ns() + period_ns_; }
    /// Sleeps until the next tick's time.
    void wait() noexcept;
    /// The tick's work is over.
    void done() noexcept { work_.add(clock_->now_ns() - began_ns_); }

    [[nodiscard]] const Histogram& late() const noexcept { return late_; }
    [[nodiscard]] const Histogram& work() const noexcept { return work_; }
    [[nodiscard]] std::uint64_t overruns() const noexcept { return overruns_.load(std::memory_order_relaxed); }
    /// Overruns of which each followed the one before.
    [[nodiscard]] std::uint64_t overruns_in_a_row() const noexcept { return in_a_row_; }

private:
    Clock* clock_;
    std::int64_t period_ns_;
    std::int64_t next_ns_ = 0;
    std::int64_t began_ns_ = 0;
    Histogram late_;
    Histogram work_;
    std::atomic<std::uint64_t> overruns_{0};
    std::uint64_t in_a_row_ = 0;
};

}  // namespace sc::linux_rt
