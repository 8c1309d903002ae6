// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// What the backup RAM stands on (reference manual, sections Power control and Reset and clock control).

namespace sc::stm32h743::backup_registers {

inline constexpr Address kAhb4enr = 0x580244E0;
inline constexpr std::uint32_t kRamClock = 1U << 28U;
inline constexpr Address kPwrCr1 = 0x58024800;
inline constexpr std::uint32_t kAccess = 1U << 8U;  ///< the backup domain may be written, CR2 too
inline constexpr Address kPwrCr2 = 0x58024808;
inline constexpr std::uint32_t kRegulator = 1U << 0U;  ///< feeds the RAM from the battery
inline constexpr std::uint32_t kRegulatorReady = 1U << 16U;

}  // namespace sc::stm32h743::backup_registers
