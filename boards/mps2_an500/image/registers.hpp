// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// Registers of the Cortex-M7's own and of the CMSDK UART that this board uses.

namespace sc::mps2_an500 {

using Register = volatile std::uint32_t;

[[gnu::always_inline]] inline Register& at(std::uintptr_t address) noexcept {
    return *reinterpret_cast<Register*>(address);
}

// SysTick: 24 bits, counting down.
inline Register& systick_control() noexcept { return at(0xE000'E010); }
inline Register& systick_reload() noexcept { return at(0xE000'E014); }
inline Register& systick_value() noexcept { return at(0xE000'E018); }
inline constexpr std::uint32_t kSystickEnable = 1;
inline constexpr std::uint32_t kSystickInterrupt = 2;
inline constexpr std::uint32_t kSystickCoreClock = 4;
inline constexpr std::uint32_t kSystickCounted = 1U << 16U;
inline constexpr std::uint32_t kSystickMax = 0xFF'FFFF;
inline constexpr std::uint32_t kCoreClockHz = 25'000'000;

// Interrupts and faults.
inline Register& interrupt_enable() noexcept { return at(0xE000'E100); }
inline Register& interrupt_control() noexcept { return at(0xE000'ED04); }
inline constexpr std::uint32_t kClearPendingSystick = 1U << 25U;
inline Register& configuration_control() noexcept { return at(0xE000'ED14); }
inline constexpr std::uint32_t kTrapDivisionByZero = 1U << 4U;
inline Register& system_handlers() noexcept { return at(0xE000'ED24); }
inline constexpr std::uint32_t kMemoryBusUsageFaults = 7U << 16U;
inline Register& configurable_fault_status() noexcept { return at(0xE000'ED28); }
inline Register& hard_fault_status() noexcept { return at(0xE000'ED2C); }
inline Register& memory_fault_address() noexcept { return at(0xE000'ED34); }
inline Register& bus_fault_address() noexcept { return at(0xE000'ED38); }

// Memory protection: one region, the 256 MB below the data RAM, where a full stack would go on.
inline Register& protection_control() noexcept { return at(0xE000'ED94); }
inline constexpr std::uint32_t kProtectionOverDefaultMap = 1U | 4U;
inline Register& protection_base() noexcept { return at(0xE000'ED9C); }
inline constexpr std::uint32_t kBelowDataRam = 0x1000'0000U | 1U << 4U | 0U;  ///< valid, region 0
inline Register& protection_attributes() noexcept { return at(0xE000'EDA0); }
inline constexpr std::uint32_t kNoAccess256Mb = 27U << 1U | 1U;

// UART0.
inline constexpr std::uint32_t kUart0ReceiveInterrupt = 0;
inline Register& uart_data() noexcept { return at(0x4000'4000); }
inline Register& uart_state() noexcept { return at(0x4000'4004); }
inline Register& uart_control() noexcept { return at(0x4000'4008); }
inline Register& uart_interrupts() noexcept { return at(0x4000'400C); }
inline Register& uart_divider() noexcept { return at(0x4000'4010); }
inline constexpr std::uint32_t kUartTransmitFull = 1;
inline constexpr std::uint32_t kUartReceiveFull = 2;
inline constexpr std::uint32_t kUartTransmitEnable = 1;
inline constexpr std::uint32_t kUartReceiveEnable = 2;
inline constexpr std::uint32_t kUartReceiveInterruptEnable = 8;
inline constexpr std::uint32_t kUartReceiveInterruptClear = 2;

}  // namespace sc::mps2_an500
