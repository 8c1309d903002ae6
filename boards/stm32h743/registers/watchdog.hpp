// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// Independent and window watchdog, and what RCC keeps of resets (reference manual, sections IWDG, WWDG and RCC).

namespace sc::stm32h743::iwdg {

inline constexpr Address kKr = 0x58004800;
inline constexpr std::uint32_t kStart = 0xCCCC;
inline constexpr std::uint32_t kUnlock = 0x5555;
inline constexpr std::uint32_t kReload = 0xAAAA;
inline constexpr Address kPr = 0x58004804;  ///< LSI / (4 << PR)
inline constexpr Address kRlr = 0x58004808;
inline constexpr std::uint32_t kReloadMask = 4095;
inline constexpr Address kSr = 0x5800480C;
inline constexpr std::uint32_t kPrescalerBusy = 1U << 0U;
inline constexpr std::uint32_t kReloadBusy = 1U << 1U;

}  // namespace sc::stm32h743::iwdg

namespace sc::stm32h743::wwdg {

inline constexpr Address kCr = 0x50003000;
inline constexpr std::uint32_t kCounter = 127U << 0U;
inline constexpr std::uint32_t kActive = 1U << 7U;
inline constexpr Address kCfr = 0x50003004;
inline constexpr std::uint32_t kWindow = 127U << 0U;
inline constexpr std::uint32_t kWarning = 1U << 9U;  ///< EWI: interrupt one count before the reset
inline constexpr std::uint32_t kTimeBase = 7U << 11U;
inline constexpr unsigned kTimeBaseShift = 11;
inline constexpr Address kSr = 0x50003008;
inline constexpr std::uint32_t kWarned = 1U << 0U;  ///< cleared by writing 0

inline constexpr Address kGcr = 0x580244A0;               ///< RCC
inline constexpr std::uint32_t kResetsSystem = 1U << 0U;  ///< WW1RSC
inline constexpr Address kApb3enr = 0x580244E4;           ///< RCC
inline constexpr std::uint32_t kClock = 1U << 6U;
inline constexpr unsigned kInterrupt = 0;  ///< position in the vector table after the exceptions

}  // namespace sc::stm32h743::wwdg

namespace sc::stm32h743::rcc {

inline constexpr Address kRsr = 0x580244D0;
inline constexpr std::uint32_t kForgetResets = 1U << 16U;
inline constexpr std::uint32_t kBrownOut = 1U << 21U;
inline constexpr std::uint32_t kPinReset = 1U << 22U;
inline constexpr std::uint32_t kPowerOn = 1U << 23U;
inline constexpr std::uint32_t kSoftware = 1U << 24U;
inline constexpr std::uint32_t kIndependentWatchdog = 1U << 26U;
inline constexpr std::uint32_t kWindowWatchdog = 1U << 28U;

}  // namespace sc::stm32h743::rcc
