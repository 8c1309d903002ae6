// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sc::stm32h743 {

/// While it lives, interrupts of the guard's priority and below wait; the safety lines' edges do not
/// (boards/stm32h743/README.md, interrupts). Some microseconds at most. On a PC there is nothing to lock: models serve
/// interrupts between the calls.
class InterruptLock {
public:
#if defined(__arm__)
    static constexpr std::uint32_t kGuardPriority = 2U << 4U;
    InterruptLock() noexcept {
        asm volatile("mrs %0, basepri" : "=r"(before_));
        asm volatile("msr basepri_max, %0" ::"r"(kGuardPriority) : "memory");
    }
    ~InterruptLock() { asm volatile("msr basepri, %0" ::"r"(before_) : "memory"); }
#else
    InterruptLock() noexcept {}
    ~InterruptLock() {}
#endif
    InterruptLock(const InterruptLock&) = delete;
    InterruptLock& operator=(const InterruptLock&) = delete;

#if defined(__arm__)
private:
    std::uint32_t before_ = 0;
#endif
};

}  // namespace sc::stm32h743
