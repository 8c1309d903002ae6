// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// TIM1, an advanced timer: outputs by compare with preload, a repetition counter, a burst of DMA into its registers
/// and a break input that takes the outputs away without the processor (reference manual, section Advanced-control
/// timers).

namespace sc::stm32h743::tim1 {

inline constexpr Address kBase = 0x40010000;
inline constexpr Address kCr1 = kBase + 0x00;
inline constexpr Address kCr2 = kBase + 0x04;
inline constexpr Address kDier = kBase + 0x0C;
inline constexpr Address kSr = kBase + 0x10;
inline constexpr Address kEgr = kBase + 0x14;
inline constexpr Address kCcmr1 = kBase + 0x18;
inline constexpr Address kCcmr2 = kBase + 0x1C;
inline constexpr Address kCcer = kBase + 0x20;
inline constexpr Address kPsc = kBase + 0x28;
inline constexpr Address kArr = kBase + 0x2C;
inline constexpr Address kRcr = kBase + 0x30;
inline constexpr Address kCcr1 = kBase + 0x34;
inline constexpr Address kCcr2 = kBase + 0x38;
inline constexpr Address kCcr3 = kBase + 0x3C;
inline constexpr Address kBdtr = kBase + 0x44;
inline constexpr Address kDcr = kBase + 0x48;
inline constexpr Address kDmar = kBase + 0x4C;
inline constexpr Address kAf1 = kBase + 0x60;

inline constexpr std::uint32_t kCounterEnable = 1U << 0U;  ///< CR1
inline constexpr std::uint32_t kReloadPreload = 1U << 7U;
inline constexpr std::uint32_t kUpdateDma = 1U << 8U;       ///< DIER
inline constexpr std::uint32_t kBreakFlag = 1U << 7U;       ///< SR, cleared by writing 0
inline constexpr std::uint32_t kGenerateUpdate = 1U << 0U;  ///< EGR

/// CCMR1 and CCMR2, of their first and second channel: the mode's fourth bit lies apart.
inline constexpr std::uint32_t kFirstPreload = 1U << 3U;
inline constexpr std::uint32_t kSecondPreload = 1U << 11U;
[[nodiscard]] constexpr std::uint32_t first_mode(std::uint32_t mode) noexcept {
    return ((mode & 7U) << 4U) | ((mode >> 3U) << 16U);
}
[[nodiscard]] constexpr std::uint32_t second_mode(std::uint32_t mode) noexcept {
    return ((mode & 7U) << 12U) | ((mode >> 3U) << 24U);
}
inline constexpr std::uint32_t kPwm1 = 6;           ///< up below the compare value
inline constexpr std::uint32_t kPwm2 = 7;           ///< up from the compare value on
inline constexpr std::uint32_t kCombinedPwm1 = 12;  ///< as kPwm1, or the other channel of the pair

inline constexpr std::uint32_t kChannel1 = 1U << 0U;  ///< CCER
inline constexpr std::uint32_t kChannel3 = 1U << 8U;

inline constexpr std::uint32_t kLockFirst = 1U << 8U;  ///< BDTR, level 1: what the break does stays until the reset
inline constexpr std::uint32_t kOffIdle = 1U << 10U;   ///< outputs are driven to their idle level when off
inline constexpr std::uint32_t kOffRun = 1U << 11U;
inline constexpr std::uint32_t kBreakEnable = 1U << 12U;
inline constexpr std::uint32_t kBreakHigh = 1U << 13U;  ///< active level of the input; without it low
inline constexpr std::uint32_t kAutomatic = 1U << 14U;  ///< outputs come back by themselves: never
inline constexpr std::uint32_t kMainOutput = 1U << 15U;

/// DCR: from which register on, as its place in words, and how many.
[[nodiscard]] constexpr std::uint32_t burst(Address first, std::uint32_t count) noexcept {
    return ((first - kBase) / 4U) | ((count - 1U) << 8U);
}
inline constexpr std::uint32_t kBreakInput = 1U << 0U;  ///< AF1: the pin is a source of the break

}  // namespace sc::stm32h743::tim1
