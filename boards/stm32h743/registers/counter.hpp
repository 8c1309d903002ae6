// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// TIM5: 32 bits, 240 MHz (reference manual, section General-purpose timers TIM2 to TIM5).

namespace sc::stm32h743::tim5 {

inline constexpr Address kCr1 = 0x40000C00;
inline constexpr Address kDier = 0x40000C0C;
inline constexpr Address kEgr = 0x40000C14;
inline constexpr Address kCnt = 0x40000C24;
inline constexpr Address kPsc = 0x40000C28;
inline constexpr Address kArr = 0x40000C2C;
inline constexpr Address kCcr1 = 0x40000C34;
inline constexpr Address kCcr2 = 0x40000C38;
inline constexpr Address kDcr = 0x40000C48;
inline constexpr Address kDmar = 0x40000C4C;
inline constexpr std::uint32_t kCompare1Dma = 1U << 9U;  ///< DIER
inline constexpr std::uint32_t kCompare2Dma = 1U << 10U;
/// A burst of `words` into the registers from `first` on.
[[nodiscard]] constexpr std::uint32_t burst(Address first, std::uint32_t words) noexcept {
    return (words - 1U) << 8U | (first - kCr1) / 4U;
}
inline constexpr std::uint32_t kCounterEnable = 1U << 0U;
inline constexpr std::uint32_t kGenerateUpdate = 1U << 0U;

inline constexpr Address kApb1lenr = 0x580244E8;
inline constexpr std::uint32_t kClock = 1U << 3U;

}  // namespace sc::stm32h743::tim5
