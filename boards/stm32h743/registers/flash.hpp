// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// Embedded flash (reference manual, section Embedded flash memory) and what of the core a reader of doubtful words
/// needs (architecture reference manual of ARMv7-M, sections System control block and Cache maintenance).

namespace sc::stm32h743::flash_registers {

inline constexpr Address kBank2 = 0x100;  ///< added to the registers of bank 1
inline constexpr Address kKeyr = 0x52002004;
inline constexpr Address kCr = 0x5200200C;
inline constexpr Address kSr = 0x52002010;
inline constexpr Address kCcr = 0x52002014;  ///< writing 1 clears the flag of SR at this place

inline constexpr std::uint32_t kFirstKey = 0x45670123;
inline constexpr std::uint32_t kSecondKey = 0xCDEF89AB;

inline constexpr std::uint32_t kLock = 1U << 0U;  ///< CR
inline constexpr std::uint32_t kProgram = 1U << 1U;
inline constexpr std::uint32_t kSectorErase = 1U << 2U;
inline constexpr std::uint32_t kSize64 = 3U << 4U;  ///< PSIZE: 64 bits at a time, for 2.7 V and more
inline constexpr std::uint32_t kStart = 1U << 7U;
inline constexpr unsigned kSectorShift = 8;
inline constexpr std::uint32_t kSectorMask = 7U << kSectorShift;

inline constexpr std::uint32_t kBusy = 1U << 0U;            ///< SR: it works
inline constexpr std::uint32_t kBufferNotEmpty = 1U << 1U;  ///< a word is half written into the buffer
inline constexpr std::uint32_t kQueued = 1U << 2U;          ///< work waits or goes on
inline constexpr std::uint32_t kWriteProtection = 1U << 17U;
inline constexpr std::uint32_t kSequence = 1U << 18U;
inline constexpr std::uint32_t kStrobe = 1U << 19U;
inline constexpr std::uint32_t kInconsistency = 1U << 21U;
inline constexpr std::uint32_t kOperation = 1U << 22U;
inline constexpr std::uint32_t kReadProtection = 1U << 23U;
inline constexpr std::uint32_t kSecure = 1U << 24U;
inline constexpr std::uint32_t kSingleError = 1U << 25U;  ///< corrected
inline constexpr std::uint32_t kDoubleError = 1U << 26U;  ///< the word that was read is lost

inline constexpr Address kScbCcr = 0xE000ED14;
inline constexpr std::uint32_t kIgnoreBusFaults = 1U << 8U;  ///< of loads while FAULTMASK is set
inline constexpr Address kCfsr = 0xE000ED28;                 ///< cleared by writing 1
inline constexpr std::uint32_t kPreciseBusFault = 1U << 9U;
inline constexpr std::uint32_t kBusFaultAddress = 1U << 15U;
inline constexpr Address kDcimvac = 0xE000EF5C;  ///< forgets the line of the data cache that holds this address

}  // namespace sc::stm32h743::flash_registers
