// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/real_time.hpp"

#include <array>
#include <cerrno>
#include <cstdint>
#include <fstream>
#include <system_error>

#include <fcntl.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

namespace sc::linux_rt {
namespace {

constexpr std::size_t kStackBytes = std::size_t{512} * 1024;
constexpr std::size_t kPage = 4096;

[[noreturn]] void fail(int error, const std::string& what) {
    throw std::system_error(error, std::generic_category(), what);
}

/// Tried and put back: the limits alone do not tell of capabilities.
bool may_have_priority(int priority) {
    const int policy = ::sched_getscheduler(0);
    sched_param before{};
    ::sched_getparam(0, &before);
    sched_param wanted{};
    wanted.sched_priority = priority;
    if (::sched_setscheduler(0, SCHED_FIFO, &wanted) != 0) {
        return false;
    }
    ::sched_setscheduler(0, policy, &before);
    return true;
}

bool may_lock_memory() {
    rlimit limit{};
    ::getrlimit(RLIMIT_MEMLOCK, &limit);
    if (limit.rlim_cur == RLIM_INFINITY) {
        return true;
    }
    // With the capability the limit does not count.
    const bool locked = ::mlockall(MCL_CURRENT) == 0;
    ::munlockall();
    return locked && limit.rlim_cur >= (std::size_t{256} << 20U);
}

}  // namespace

bool kernel_is_real_time() {
    std::ifstream file("/sys/kernel/realtime");
    int value = 0;
    return file >> value && value == 1;
}

std::vector<std::string> missing_for_real_time(const RealTimeOptions& options) {
    std::vector<std::string> missing;
    if (!kernel_is_real_time()) {
        missing.emplace_back("the kernel is not PREEMPT_RT: apt-get install linux-image-rt-amd64, and start it");
    }
    if (!may_have_priority(options.priority)) {
        missing.push_back(
            "no right to SCHED_FIFO priority " + std::to_string(options.priority) +
            ": start it by the systemd unit (LimitRTPRIO=), as root, or setcap cap_sys_nice,cap_ipc_lock+ep");
    }
    if (!may_lock_memory()) {
        missing.emplace_back("no right to lock memory: LimitMEMLOCK=infinity in the unit, or cap_ipc_lock");
    }
    if (options.cpu && (*options.cpu < 0 || *options.cpu >= ::sysconf(_SC_NPROCESSORS_ONLN))) {
        missing.push_back("there is no processor " + std::to_string(*options.cpu) + " (--cpu)");
    }
    return missing;
}

void lock_memory() {
    ::mallopt(M_TRIM_THRESHOLD, -1);
    ::mallopt(M_MMAP_MAX, 0);
    if (::mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
        fail(errno, "lock the memory");
    }
}

void touch_stack() noexcept {
    std::array<volatile std::uint8_t, kStackBytes> stack;  // NOLINT(cppcoreguidelines-pro-type-member-init): touched
    for (std::size_t i = 0; i < stack.size(); i += kPage) {
        stack[i] = 0;
    }
}

void make_thread_real_time(const RealTimeOptions& options) {
    if (options.cpu) {
        cpu_set_t set;
        CPU_ZERO(&set);
        CPU_SET(static_cast<std::size_t>(*options.cpu), &set);
        if (const int error = ::pthread_setaffinity_np(::pthread_self(), sizeof set, &set); error != 0) {
            fail(error, "run on processor " + std::to_string(*options.cpu));
        }
    }
    sched_param wanted{};
    wanted.sched_priority = options.priority;
    if (const int error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &wanted); error != 0) {
        fail(error, "SCHED_FIFO priority " + std::to_string(options.priority));
    }
    touch_stack();
}

AwakeProcessors::AwakeProcessors() noexcept : file_(::open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC)) {
    const std::int32_t most_us = 0;
    if (file_ >= 0 && ::write(file_, &most_us, sizeof most_us) != sizeof most_us) {
        ::close(file_);
        file_ = -1;
    }
}

AwakeProcessors::~AwakeProcessors() {
    if (file_ >= 0) {
        ::close(file_);
    }
}

}  // namespace sc::linux_rt
