// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// FDCAN1 and FDCAN2 and the 10 KB of message RAM that they share (reference manual, section FD Controller Area
/// Network). Offsets are from the base of an instance.

namespace sc::stm32h743::fdcan {

inline constexpr Address kApb1henr = 0x580244EC;  ///< RCC: clocks of the upper half of APB1
inline constexpr std::uint32_t kClock = 1U << 8U;

inline constexpr Address kFdcan1 = 0x4000A000;
inline constexpr Address kFdcan2 = 0x4000A400;
inline constexpr Address kMessageRam = 0x4000AC00;
inline constexpr std::uint32_t kMessageRamBytes = 10240;

inline constexpr Address kEndn = 0x04;
inline constexpr Address kDbtp = 0x0C;
inline constexpr Address kCccr = 0x18;
inline constexpr Address kNbtp = 0x1C;
inline constexpr Address kTscc = 0x20;
inline constexpr Address kTscv = 0x24;
inline constexpr Address kEcr = 0x40;
inline constexpr Address kPsr = 0x44;
inline constexpr Address kTdcr = 0x48;
inline constexpr Address kIr = 0x50;
inline constexpr Address kIe = 0x54;
inline constexpr Address kIls = 0x58;
inline constexpr Address kIle = 0x5C;
inline constexpr Address kGfc = 0x80;
inline constexpr Address kSidfc = 0x84;
inline constexpr Address kXidfc = 0x88;
inline constexpr Address kRxf0c = 0xA0;
inline constexpr Address kRxf0s = 0xA4;
inline constexpr Address kRxf0a = 0xA8;
inline constexpr Address kRxesc = 0xBC;
inline constexpr Address kTxbc = 0xC0;
inline constexpr Address kTxfqs = 0xC4;
inline constexpr Address kTxesc = 0xC8;
inline constexpr Address kTxbrp = 0xCC;
inline constexpr Address kTxbar = 0xD0;

inline constexpr std::uint32_t kEndianTest = 0x87654321;  ///< what ENDN reads

inline constexpr std::uint32_t kInit = 1U << 0U;  ///< CCCR
inline constexpr std::uint32_t kChangeEnable = 1U << 1U;
inline constexpr std::uint32_t kStopAcknowledged = 1U << 3U;
inline constexpr std::uint32_t kStopRequest = 1U << 4U;
inline constexpr std::uint32_t kFdEnable = 1U << 8U;
inline constexpr std::uint32_t kSwitchEnable = 1U << 9U;

inline constexpr std::uint32_t kDelayCompensation = 1U << 23U;  ///< DBTP

inline constexpr std::uint32_t kStampByBits = 1U << 0U;  ///< TSCC: by nominal bit times

inline constexpr std::uint32_t kTransmitErrors = 0xFFU << 0U;  ///< ECR
inline constexpr std::uint32_t kReceiveErrors = 0x7FU << 8U;
inline constexpr std::uint32_t kLoggedErrors = 0xFFU << 16U;  ///< since ECR was read

inline constexpr std::uint32_t kLastError = 7U << 0U;  ///< PSR; 7 after it was read
inline constexpr std::uint32_t kNoAck = 3;
inline constexpr std::uint32_t kErrorPassive = 1U << 5U;
inline constexpr std::uint32_t kErrorWarning = 1U << 6U;
inline constexpr std::uint32_t kBusOff = 1U << 7U;

inline constexpr std::uint32_t kNewInFifo0 = 1U << 0U;  ///< IR and IE; cleared by writing 1
inline constexpr std::uint32_t kLostInFifo0 = 1U << 3U;
inline constexpr std::uint32_t kBusOffChanged = 1U << 25U;
inline constexpr std::uint32_t kAllInterrupts = 0x3FCFFFFFU;
inline constexpr std::uint32_t kLine0 = 1U << 0U;  ///< ILE

inline constexpr std::uint32_t kFifoSizeAt = 16;          ///< RXF0C
inline constexpr std::uint32_t kFillLevel = 0x7FU << 0U;  ///< RXF0S
inline constexpr std::uint32_t kGetIndex = 0x3FU << 8U;
inline constexpr std::uint32_t kGetIndexAt = 8;

inline constexpr std::uint32_t kTxFifoSizeAt = 24;   ///< TXBC
inline constexpr std::uint32_t kTxFull = 1U << 21U;  ///< TXFQS
inline constexpr std::uint32_t kPutIndex = 0x1FU << 16U;
inline constexpr std::uint32_t kPutIndexAt = 16;
inline constexpr std::uint32_t kData64 = 7;  ///< RXESC, TXESC: elements have room for 64 bytes

/// Elements of the message RAM: two words of head, then the data. First word:
inline constexpr std::uint32_t kExtended = 1U << 30U;
inline constexpr std::uint32_t kRemote = 1U << 29U;
inline constexpr std::uint32_t kStandardAt = 18;
/// Second word:
inline constexpr std::uint32_t kFdFormat = 1U << 21U;
inline constexpr std::uint32_t kRateSwitch = 1U << 20U;
inline constexpr std::uint32_t kLengthAt = 16;
inline constexpr std::uint32_t kStamp = 0xFFFFU;

}  // namespace sc::stm32h743::fdcan
