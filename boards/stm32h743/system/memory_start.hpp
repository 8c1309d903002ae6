// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sc::stm32h743 {

/// `bank`: of the flash, 1 or 2, from which this image runs. Clocks of SRAM1 to SRAM3, memory protection by
/// memory_map.hpp, then both caches. After code and data were copied, before anything is read by DMA. False when the
/// core has too few regions. 1 ms on HSI. Any state before.
[[nodiscard]] bool start_memory(unsigned bank) noexcept;

}  // namespace sc::stm32h743
