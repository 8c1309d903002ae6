// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// The port of the galvo's lines and the clocks of what drives it (reference manual, sections GPIO and RCC).

namespace sc::stm32h743::optics_port {

inline constexpr Address kGpioE = 0x58021000;
inline constexpr Address kModer = kGpioE + 0x00;
inline constexpr Address kOtyper = kGpioE + 0x04;
inline constexpr Address kOspeedr = kGpioE + 0x08;
inline constexpr Address kPupdr = kGpioE + 0x0C;
inline constexpr Address kBsrr = kGpioE + 0x18;
inline constexpr Address kAfrh = kGpioE + 0x24;  ///< pins 8 to 15, four bits each

inline constexpr Address kRcc = 0x58024400;
inline constexpr Address kAhb1enr = kRcc + 0xD8;
inline constexpr Address kAhb2enr = kRcc + 0xDC;
inline constexpr Address kAhb4enr = kRcc + 0xE0;
inline constexpr Address kApb1lenr = kRcc + 0xE8;
inline constexpr Address kApb2enr = kRcc + 0xF0;
inline constexpr std::uint32_t kDma1Clock = 1U << 0U;    ///< AHB1ENR
inline constexpr std::uint32_t kDma2Clock = 1U << 1U;    ///< AHB1ENR
inline constexpr std::uint32_t kSram1Clock = 1U << 29U;  ///< AHB2ENR
inline constexpr std::uint32_t kSram2Clock = 1U << 30U;  ///< AHB2ENR
inline constexpr std::uint32_t kGpioEClock = 1U << 4U;   ///< AHB4ENR
inline constexpr std::uint32_t kTim6Clock = 1U << 4U;    ///< APB1LENR
inline constexpr std::uint32_t kTim1Clock = 1U << 0U;    ///< APB2ENR

}  // namespace sc::stm32h743::optics_port
