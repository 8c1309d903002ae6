// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// What a fault handler touches: the core's fault status (architecture reference manual of ARMv7-M, section System
/// control block), ports E and F, the main output of TIM1, backup RAM and its lock (reference manual, sections GPIO,
/// TIM1, RCC and PWR).

namespace sc::stm32h743::fault_registers {

inline constexpr Address kAircr = 0xE000ED0C;
inline constexpr std::uint32_t kResetRequest = 0x05FA0004;  ///< with its key
inline constexpr Address kShcsr = 0xE000ED24;
inline constexpr std::uint32_t kMemManage = 1U << 16U;
inline constexpr std::uint32_t kBusFault = 1U << 17U;
inline constexpr std::uint32_t kUsageFault = 1U << 18U;
inline constexpr Address kCfsr = 0xE000ED28;
inline constexpr std::uint32_t kMmarValid = 1U << 7U;
inline constexpr std::uint32_t kBfarValid = 1U << 15U;
inline constexpr Address kHfsr = 0xE000ED2C;
inline constexpr Address kMmfar = 0xE000ED34;
inline constexpr Address kBfar = 0xE000ED38;
inline constexpr Address kAbfsr = 0xE000EFA8;

inline constexpr Address kGpioE = 0x58021000;
inline constexpr Address kGpioF = 0x58021400;
inline constexpr Address kModer = 0x00;  ///< added to a port; two bits a pin, 1: output
inline constexpr Address kBsrr = 0x18;   ///< added to a port; upper half resets
inline constexpr Address kTim1Bdtr = 0x40010044;
inline constexpr std::uint32_t kMainOutput = 1U << 15U;

inline constexpr Address kAhb4enr = 0x580244E0;
inline constexpr std::uint32_t kGpioEClock = 1U << 4U;
inline constexpr std::uint32_t kGpioFClock = 1U << 5U;
inline constexpr std::uint32_t kBackupRamClock = 1U << 28U;
inline constexpr Address kApb2enr = 0x580244F0;
inline constexpr std::uint32_t kTim1Clock = 1U << 0U;
inline constexpr Address kCifr = 0x58024464;  ///< RCC: bit 10, HSE has stopped
inline constexpr Address kPwrCr1 = 0x58024800;
inline constexpr std::uint32_t kUnlockBackup = 1U << 8U;  ///< DBP
inline constexpr Address kFlashSr1 = 0x52002010;
inline constexpr Address kFlashSr2 = 0x52002110;

}  // namespace sc::stm32h743::fault_registers
