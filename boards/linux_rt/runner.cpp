// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/runner.hpp"

#include "boards/linux_rt/allocation_watch.hpp"

namespace sc::linux_rt {
namespace {

constexpr std::int64_t kStopTicks = 3'000;
constexpr std::int64_t kLastTicks = 4;  ///< for what was said last to be sent
constexpr std::int64_t kLookNs = 200'000;

}  // namespace

void Runner::wait_for_answers() {
    const std::int64_t end = clock_->now_ns() + options_.answer_timeout_ns;
    while (!loop_->settled()) {
        if (clock_->now_ns() >= end) {
            drives_->give_up();
            return;
        }
        drives_->wait(kLookNs);
    }
}

RunEnd Runner::run(const std::atomic<bool>& stop) {
    RunEnd end = RunEnd::stopped;
    const std::uint64_t before = forbidden_allocations();
    const NoAllocation watched;
    std::int64_t left = -1;  // ticks until it is given up; -1: nobody has asked
    std::int64_t last = kLastTicks;
    pacer_.begin();
    while (true) {
        pacer_.wait();
        loop_->tick();
        pacer_.done();
        ticks_.fetch_add(1, std::memory_order_relaxed);
        allocations_.store(forbidden_allocations() - before, std::memory_order_relaxed);
        if (options_.pace == Pace::drives) {
            wait_for_answers();
        } else if (options_.most_overruns > 0 && pacer_.overruns_in_a_row() >= options_.most_overruns && left < 0) {
            end = RunEnd::overruns;
        }
        if (left < 0) {
            if (stop.load(std::memory_order_relaxed) || end == RunEnd::overruns) {
                loop_->stop();
                left = kStopTicks;
            }
            continue;
        }
        last = loop_->stopped() ? last - 1 : kLastTicks;
        if (last == 0) {
            break;
        }
        if (--left == 0) {
            end = RunEnd::not_stopped;
            break;
        }
    }
    loop_->make_safe();
    return end;
}

}  // namespace sc::linux_rt
