// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/pacer.hpp"

#include <cerrno>
#include <ctime>

namespace sc::linux_rt {

std::int64_t SystemClock::now_ns() noexcept {
    timespec t{};
    ::clock_gettime(CLOCK_MONOTONIC, &t);
    return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

void SystemClock::sleep_until(std::int64_t ns) noexcept {
    const timespec t{static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
    while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
    }
}

void Pacer::wait() noexcept {
    clock_->sleep_until(next_ns_);
    began_ns_ = clock_->now_ns();
    const std::int64_t late = began_ns_ - next_ns_;
    late_.add(late > 0 ? late : 0);
    if (late < period_ns_) {
        next_ns_ += period_ns_;
        in_a_row_ = 0;
        return;
    }
    overruns_.fetch_add(1, std::memory_order_relaxed);
    ++in_a_row_;
    next_ns_ = began_ns_ + period_ns_;
}

}  // namespace sc::linux_rt
