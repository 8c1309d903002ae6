// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// SPI3 as a receiving slave, and the port of its pins (reference manual, section SPI).

namespace sc::stm32h743::spi3 {

inline constexpr Address kBase = 0x40003C00;
inline constexpr Address kCr1 = kBase + 0x00;
inline constexpr Address kCfg1 = kBase + 0x08;
inline constexpr Address kCfg2 = kBase + 0x0C;
inline constexpr Address kSr = kBase + 0x14;
inline constexpr Address kIfcr = kBase + 0x18;
inline constexpr Address kRxdr = kBase + 0x30;

inline constexpr std::uint32_t kEnable = 1U << 0U;       ///< CR1
inline constexpr std::uint32_t kReceiveDma = 1U << 14U;  ///< CFG1
/// CFG1: bits of a word; the checksum that is off stays at its 8 bits.
[[nodiscard]] constexpr std::uint32_t word_bits(std::uint32_t bits) noexcept { return 7U << 16U | (bits - 1U); }
inline constexpr std::uint32_t kReceiveOnly = 2U << 17U;     ///< CFG2: COMM
inline constexpr std::uint32_t kSoftwareSelect = 1U << 26U;  ///< CFG2: SSM; SSI of CR1 low selects
inline constexpr std::uint32_t kOverrun = 1U << 6U;          ///< SR, IFCR

inline constexpr Address kApb1lenr = 0x580244E8;
inline constexpr std::uint32_t kClock = 1U << 15U;

}  // namespace sc::stm32h743::spi3
