// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// USARTs (reference manual, section Universal synchronous/asynchronous receiver transmitter), their clocks and what of
/// DMA and its multiplexer is theirs. Offsets are from the base of an instance.

namespace sc::stm32h743::usart {

inline constexpr Address kAhb1enr = 0x580244D8;
inline constexpr std::uint32_t kDma1Clock = 1U << 0U;
inline constexpr Address kApb1lenr = 0x580244E8;
inline constexpr std::uint32_t kUsart2Clock = 1U << 17U;
inline constexpr std::uint32_t kUsart3Clock = 1U << 18U;
inline constexpr Address kApb2enr = 0x580244F0;
inline constexpr std::uint32_t kUsart6Clock = 1U << 5U;

inline constexpr Address kUsart2 = 0x40004400;
inline constexpr Address kUsart3 = 0x40004800;
inline constexpr Address kUsart6 = 0x40011400;

inline constexpr Address kCr1 = 0x00;
inline constexpr Address kCr2 = 0x04;
inline constexpr Address kCr3 = 0x08;
inline constexpr Address kBrr = 0x0C;
inline constexpr Address kRtor = 0x14;
inline constexpr Address kIsr = 0x1C;
inline constexpr Address kIcr = 0x20;
inline constexpr Address kRdr = 0x24;
inline constexpr Address kTdr = 0x28;

inline constexpr std::uint32_t kEnable = 1U << 0U;  ///< CR1
inline constexpr std::uint32_t kReceive = 1U << 2U;
inline constexpr std::uint32_t kTransmit = 1U << 3U;
inline constexpr std::uint32_t kIdleInterrupt = 1U << 4U;
inline constexpr std::uint32_t kReceiveInterrupt = 1U << 5U;
inline constexpr std::uint32_t kCompleteInterrupt = 1U << 6U;
inline constexpr std::uint32_t kEmptyInterrupt = 1U << 7U;
inline constexpr std::uint32_t kParity = 1U << 10U;    ///< even
inline constexpr std::uint32_t kNineBits = 1U << 12U;  ///< with the parity bit
inline constexpr std::uint32_t kReleaseAt = 16;        ///< sixteenths of a bit from the stop bit to the driver's end
inline constexpr std::uint32_t kAssertAt = 21;         ///< sixteenths of a bit from the driver's start to the start bit
inline constexpr std::uint32_t kTimeoutInterrupt = 1U << 26U;

inline constexpr std::uint32_t kTimeoutEnable = 1U << 23U;  ///< CR2

inline constexpr std::uint32_t kDmaReceive = 1U << 6U;  ///< CR3
inline constexpr std::uint32_t kDmaTransmit = 1U << 7U;
inline constexpr std::uint32_t kDriverEnable = 1U << 14U;

inline constexpr std::uint32_t kParityError = 1U << 0U;  ///< ISR; and where ICR takes it back
inline constexpr std::uint32_t kFramingError = 1U << 1U;
inline constexpr std::uint32_t kNoise = 1U << 2U;
inline constexpr std::uint32_t kOverrun = 1U << 3U;
inline constexpr std::uint32_t kIdle = 1U << 4U;
inline constexpr std::uint32_t kReceived = 1U << 5U;
inline constexpr std::uint32_t kComplete = 1U << 6U;
inline constexpr std::uint32_t kEmpty = 1U << 7U;
inline constexpr std::uint32_t kTimeout = 1U << 11U;
inline constexpr std::uint32_t kBusy = 1U << 16U;  ///< a byte is coming
inline constexpr std::uint32_t kTransmitReady = 1U << 21U;
inline constexpr std::uint32_t kReceiveReady = 1U << 22U;

/// Of a DMA stream: needed with USARTs, or the stream may lock.
inline constexpr std::uint32_t kBufferable = 1U << 20U;
inline constexpr std::uint32_t kRequestUsart3Rx = 45;
inline constexpr std::uint32_t kRequestUsart3Tx = 46;

}  // namespace sc::stm32h743::usart
