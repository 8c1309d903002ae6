// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// Interrupts of the core (architecture reference manual of ARMv7-M, section NVIC and System control block). The chip
/// has four bits of priority, the upper ones of a byte.

namespace sc::stm32h743::nvic {

inline constexpr Address kIser = 0xE000E100;  ///< one bit an interrupt, 32 a word; writing 1 enables
inline constexpr Address kIcer = 0xE000E180;
inline constexpr Address kIcpr = 0xE000E280;
inline constexpr Address kIpr = 0xE000E400;  ///< one byte an interrupt
inline constexpr Address kIcsr = 0xE000ED04;
inline constexpr std::uint32_t kPendPendSv = 1U << 28U;
inline constexpr Address kAircr = 0xE000ED0C;
inline constexpr std::uint32_t kKey = 0x05FA0000;
inline constexpr std::uint32_t kGroups = 7U << 8U;       ///< PRIGROUP
inline constexpr std::uint32_t kAllPreempt = 3U << 8U;   ///< all four bits say who breaks into whom
inline constexpr Address kPendSvPriority = 0xE000ED22;   ///< a byte of SHPR3
inline constexpr Address kFaultPriorities = 0xE000ED18;  ///< SHPR1: memory, bus, usage; one byte each
inline constexpr unsigned kPriorityShift = 4;
inline constexpr unsigned kWords = 5;  ///< of 32 interrupts, for 150

}  // namespace sc::stm32h743::nvic
