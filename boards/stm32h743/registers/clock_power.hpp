// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// What the clock tree stands on: RCC, PWR, the access control of the flash, the overdrive in SYSCFG and the revision
/// of the chip (reference manual, sections RCC, PWR, Embedded flash memory, SYSCFG and Debug).

namespace sc::stm32h743::rcc {

inline constexpr Address kCr = 0x58024400;
inline constexpr std::uint32_t kHsiOn = 1U << 0U;
inline constexpr std::uint32_t kHsiReady = 1U << 2U;
inline constexpr std::uint32_t kHsiDivider = 3U << 3U;  ///< 0: 64 MHz
inline constexpr std::uint32_t kHseOn = 1U << 16U;
inline constexpr std::uint32_t kHseReady = 1U << 17U;
inline constexpr std::uint32_t kHseBypass = 1U << 18U;
inline constexpr std::uint32_t kHseGuard = 1U << 19U;  ///< CSSHSEON: NMI and HSI when HSE stops
inline constexpr std::uint32_t kPll1On = 1U << 24U;
inline constexpr std::uint32_t kPll1Ready = 1U << 25U;
inline constexpr std::uint32_t kPll2On = 1U << 26U;
inline constexpr std::uint32_t kPll2Ready = 1U << 27U;

inline constexpr Address kCfgr = 0x58024410;
inline constexpr std::uint32_t kSwitch = 7U << 0U;
inline constexpr std::uint32_t kSwitchState = 7U << 3U;
inline constexpr unsigned kSwitchStateShift = 3;
inline constexpr std::uint32_t kFromHsi = 0;
inline constexpr std::uint32_t kFromPll1 = 3;
inline constexpr std::uint32_t kTimerPrescaler = 1U << 15U;  ///< TIMPRE

inline constexpr Address kD1cfgr = 0x58024418;
inline constexpr std::uint32_t kHpre = 15U << 0U;
inline constexpr std::uint32_t kD1ppre = 7U << 4U;
inline constexpr std::uint32_t kD1cpre = 15U << 8U;
inline constexpr Address kD2cfgr = 0x5802441C;
inline constexpr std::uint32_t kD2ppre1 = 7U << 4U;
inline constexpr std::uint32_t kD2ppre2 = 7U << 8U;
inline constexpr Address kD3cfgr = 0x58024420;
inline constexpr std::uint32_t kD3ppre = 7U << 4U;

inline constexpr Address kPllckselr = 0x58024428;
inline constexpr std::uint32_t kPllSource = 3U << 0U;
inline constexpr std::uint32_t kPllFromHse = 2;
inline constexpr std::uint32_t kDivm1 = 63U << 4U;
inline constexpr std::uint32_t kDivm2 = 63U << 12U;

inline constexpr Address kPllcfgr = 0x5802442C;
inline constexpr std::uint32_t kPll1Fraction = 1U << 0U;
inline constexpr std::uint32_t kPll1Medium = 1U << 1U;  ///< VCOSEL
inline constexpr std::uint32_t kPll1Range = 3U << 2U;
inline constexpr std::uint32_t kPll2Fraction = 1U << 4U;
inline constexpr std::uint32_t kPll2Medium = 1U << 5U;
inline constexpr std::uint32_t kPll2Range = 3U << 6U;
inline constexpr std::uint32_t kDivp1En = 1U << 16U;
inline constexpr std::uint32_t kDivq1En = 1U << 17U;
inline constexpr std::uint32_t kDivr1En = 1U << 18U;
inline constexpr std::uint32_t kDivp2En = 1U << 19U;
inline constexpr std::uint32_t kDivq2En = 1U << 20U;
inline constexpr std::uint32_t kDivr2En = 1U << 21U;

inline constexpr Address kPll1divr = 0x58024430;
inline constexpr Address kPll2divr = 0x58024438;
inline constexpr std::uint32_t kDivn = 511U << 0U;  ///< these four: factor - 1
inline constexpr std::uint32_t kDivp = 127U << 9U;
inline constexpr std::uint32_t kDivq = 127U << 16U;
inline constexpr std::uint32_t kDivr = 127U << 24U;

inline constexpr Address kD2ccip1r = 0x58024450;
inline constexpr std::uint32_t kFdcanSource = 3U << 28U;
inline constexpr std::uint32_t kFdcanFromPll2q = 2U << 28U;
inline constexpr Address kD2ccip2r = 0x58024454;
inline constexpr std::uint32_t kUsart234578Source = 7U << 0U;  ///< 0: clock of APB1
inline constexpr std::uint32_t kUsart16Source = 7U << 3U;      ///< 0: clock of APB2

inline constexpr Address kApb4enr = 0x580244F4;
inline constexpr std::uint32_t kSyscfgEn = 1U << 1U;

}  // namespace sc::stm32h743::rcc

namespace sc::stm32h743::pwr {

inline constexpr Address kCsr1 = 0x58024804;
inline constexpr std::uint32_t kActualReady = 1U << 13U;
inline constexpr Address kCr3 = 0x5802480C;
inline constexpr std::uint32_t kBypass = 1U << 0U;
inline constexpr std::uint32_t kLdoOn = 1U << 1U;
inline constexpr std::uint32_t kUpdateOpen = 1U << 2U;  ///< SCUEN: the supply may be written, once after power comes
inline constexpr Address kD3cr = 0x58024818;
inline constexpr std::uint32_t kScaleReady = 1U << 13U;
inline constexpr std::uint32_t kScale = 3U << 14U;
inline constexpr std::uint32_t kScale1 = 3U << 14U;

}  // namespace sc::stm32h743::pwr

namespace sc::stm32h743::clock_neighbours {

inline constexpr Address kFlashAcr = 0x52002000;
inline constexpr std::uint32_t kLatency = 15U << 0U;
inline constexpr std::uint32_t kWriteDelay = 3U << 4U;  ///< WRHIGHFREQ
inline constexpr unsigned kWriteDelayShift = 4;

inline constexpr Address kSyscfgPwrcr = 0x5800042C;
inline constexpr std::uint32_t kOverdrive = 1U << 0U;

inline constexpr Address kIdCode = 0x5C001000;  ///< DBGMCU_IDC
inline constexpr unsigned kRevisionShift = 16;

}  // namespace sc::stm32h743::clock_neighbours
