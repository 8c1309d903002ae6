// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// EXTI with the port selection in SYSCFG, inputs of port E and TIM7 (reference manual, sections EXTI, SYSCFG, GPIO and
/// Basic timers).

namespace sc::stm32h743::lines_registers {

inline constexpr Address kRising = 0x58000000;      ///< RTSR1
inline constexpr Address kFalling = 0x58000004;     ///< FTSR1
inline constexpr Address kMask = 0x58000080;        ///< CPUIMR1: 1 lets the interrupt through
inline constexpr Address kPending = 0x58000088;     ///< CPUPR1: cleared by writing 1
inline constexpr Address kPortOf4To7 = 0x5800040C;  ///< SYSCFG_EXTICR2, four bits a line
inline constexpr Address kPortOf8To11 = 0x58000410;
inline constexpr std::uint32_t kPortE = 4;

inline constexpr Address kApb4enr = 0x580244F4;
inline constexpr std::uint32_t kSyscfgClock = 1U << 1U;
inline constexpr std::uint32_t kTim7Clock = 1U << 5U;  ///< APB1LENR

inline constexpr Address kInputs = 0x58021010;  ///< GPIOE_IDR

inline constexpr Address kTim7Cr1 = 0x40001400;
inline constexpr Address kTim7Dier = 0x4000140C;
inline constexpr Address kTim7Sr = 0x40001410;
inline constexpr Address kTim7Egr = 0x40001414;
inline constexpr Address kTim7Psc = 0x40001428;
inline constexpr Address kTim7Arr = 0x4000142C;
inline constexpr std::uint32_t kCounterEnable = 1U << 0U;
inline constexpr std::uint32_t kUpdateInterrupt = 1U << 0U;  ///< DIER
inline constexpr std::uint32_t kUpdateFlag = 1U << 0U;       ///< SR, cleared by writing 0
inline constexpr std::uint32_t kGenerateUpdate = 1U << 0U;

}  // namespace sc::stm32h743::lines_registers
