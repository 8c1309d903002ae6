// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// TIM6, a basic timer: it counts and asks for DMA (reference manual, section Basic timers).

namespace sc::stm32h743::tim6 {

inline constexpr Address kBase = 0x40001000;
inline constexpr Address kCr1 = kBase + 0x00;
inline constexpr Address kDier = kBase + 0x0C;
inline constexpr Address kSr = kBase + 0x10;
inline constexpr Address kEgr = kBase + 0x14;
inline constexpr Address kCnt = kBase + 0x24;
inline constexpr Address kPsc = kBase + 0x28;
inline constexpr Address kArr = kBase + 0x2C;

inline constexpr std::uint32_t kCounterEnable = 1U << 0U;
inline constexpr std::uint32_t kPreload = 1U << 7U;
inline constexpr std::uint32_t kUpdateDma = 1U << 8U;
inline constexpr std::uint32_t kUpdateFlag = 1U << 0U;
inline constexpr std::uint32_t kGenerateUpdate = 1U << 0U;

}  // namespace sc::stm32h743::tim6
