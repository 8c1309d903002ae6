// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace sc::linux_rt {

struct RealTimeOptions {
    int priority = 80;       ///< SCHED_FIFO; above the kernel's interrupt threads (50)
    std::optional<int> cpu;  ///< the loop's processor; none: any
};

/// What this process lacks to be real-time, each with what to do about it. Empty: nothing.
[[nodiscard]] std::vector<std::string> missing_for_real_time(const RealTimeOptions& options);

/// All pages of the process, present and future, stay in memory; freed memory stays with the process. Throws
/// std::system_error.
void lock_memory();
/// Of the calling thread: its class and priority, its processor, and its stack touched down to 512 kB. Throws
/// std::system_error.
void make_thread_real_time(const RealTimeOptions& options);
/// Touches the calling thread's stack, so that it never faults later.
void touch_stack() noexcept;

/// Keeps the processors out of their deep sleep while it lives (/dev/cpu_dma_latency); without the right to, it does
/// nothing, and `held` says so.
class AwakeProcessors {
public:
    AwakeProcessors() noexcept;
    ~AwakeProcessors();
    AwakeProcessors(const AwakeProcessors&) = delete;
    AwakeProcessors& operator=(const AwakeProcessors&) = delete;
    [[nodiscard]] bool held() const noexcept { return file_ >= 0; }

private:
    int file_ = -1;
};

/// Whether this kernel is a PREEMPT_RT one.
[[nodiscard]] bool kernel_is_real_time();

}  // namespace sc::linux_rt
