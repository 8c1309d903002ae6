// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/flash.hpp"

namespace sc::stm32h743 {

/// While one lives a load that fails is no fault but a flag (architecture reference manual of ARMv7-M, BFHFNMIGN), and
/// no interrupt is served: keep it short.
class FaultGuard {
public:
    FaultGuard() noexcept {
#if defined(__arm__)
        asm volatile("mrs %0, faultmask\n\tcpsid f" : "=r"(mask_)::"memory");
#endif
        set_bits(flash_registers::kScbCcr, flash_registers::kIgnoreBusFaults);
        barrier();
    }
    FaultGuard(const FaultGuard&) = delete;
    FaultGuard& operator=(const FaultGuard&) = delete;
    ~FaultGuard() {
        barrier();
        write32(flash_registers::kCfsr, kFlags);
        clear_bits(flash_registers::kScbCcr, flash_registers::kIgnoreBusFaults);
        barrier();
#if defined(__arm__)
        asm volatile("msr faultmask, %0" ::"r"(mask_) : "memory");
#endif
    }
    /// A load has failed since it lives.
    [[nodiscard]] bool failed() const noexcept {
        barrier();
        return (read32(flash_registers::kCfsr) & flash_registers::kPreciseBusFault) != 0;
    }

private:
    static constexpr std::uint32_t kFlags = flash_registers::kPreciseBusFault | flash_registers::kBusFaultAddress;
#if defined(__arm__)
    std::uint32_t mask_ = 0;
#endif
};

}  // namespace sc::stm32h743
