// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// Memory protection and caches of the core (architecture reference manual of ARMv7-M, sections MPU and System control
/// block; Cortex-M7 technical reference manual, section Cache), and the clocks of SRAM1 to SRAM3 (reference manual,
/// RCC).

namespace sc::stm32h743::core_memory {

inline constexpr Address kMpuType = 0xE000ED90;
inline constexpr std::uint32_t kRegionCount = 255U << 8U;
inline constexpr unsigned kRegionCountShift = 8;
inline constexpr Address kMpuCtrl = 0xE000ED94;
inline constexpr std::uint32_t kMpuEnable = 1U << 0U;
inline constexpr std::uint32_t kDefaultMap = 1U << 2U;  ///< PRIVDEFENA: what no region names is as without an MPU
inline constexpr Address kMpuRnr = 0xE000ED98;
inline constexpr Address kMpuRbar = 0xE000ED9C;
inline constexpr Address kMpuRasr = 0xE000EDA0;
inline constexpr std::uint32_t kRegionEnable = 1U << 0U;
inline constexpr std::uint32_t kRegionSize = 31U << 1U;  ///< log2 of the bytes, less 1
inline constexpr std::uint32_t kBufferable = 1U << 16U;
inline constexpr std::uint32_t kCacheable = 1U << 17U;
inline constexpr std::uint32_t kTypeExtension = 7U << 19U;
inline constexpr std::uint32_t kTypeExtension1 = 1U << 19U;
inline constexpr std::uint32_t kAccess = 7U << 24U;
inline constexpr std::uint32_t kReadWrite = 3U << 24U;
inline constexpr std::uint32_t kReadOnly = 6U << 24U;
inline constexpr std::uint32_t kNeverExecute = 1U << 28U;

inline constexpr Address kCcr = 0xE000ED14;
inline constexpr std::uint32_t kDivisionTrap = 1U << 4U;
inline constexpr std::uint32_t kDataCache = 1U << 16U;
inline constexpr std::uint32_t kCodeCache = 1U << 17U;
inline constexpr Address kCsselr = 0xE000ED84;
inline constexpr Address kIciallu = 0xE000EF50;
inline constexpr Address kDcisw = 0xE000EF60;
inline constexpr std::uint32_t kDataCacheSets = 128;  ///< 16 KB in lines of 32 bytes, four ways
inline constexpr std::uint32_t kDataCacheWays = 4;
inline constexpr unsigned kSetShift = 5;
inline constexpr unsigned kWayShift = 30;

inline constexpr Address kAhb2enr = 0x580244DC;
inline constexpr std::uint32_t kSram1Clock = 1U << 29U;
inline constexpr std::uint32_t kSram2Clock = 1U << 30U;
inline constexpr std::uint32_t kSram3Clock = 1U << 31U;

}  // namespace sc::stm32h743::core_memory
