// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// TIM5: 32 bits, 240 MHz (reference manual, section General-purpose timers TIM2 to TIM5).

namespace sc::stm32h743::tim5 {

inline constexpr Address kCr1 = 0x40000C00;
inline constexpr Address kEgr = 0x40000C14;
inline constexpr Address kCnt = 0x40000C24;
inline constexpr Address kPsc = 0x40000C28;
inline constexpr Address kArr = 0x40000C2C;
inline constexpr std::uint32_t kCounterEnable = 1U << 0U;
inline constexpr std::uint32_t kGenerateUpdate = 1U << 0U;

inline constexpr Address kApb1lenr = 0x580244E8;
inline constexpr std::uint32_t kClock = 1U << 3U;

}  // namespace sc::stm32h743::tim5
