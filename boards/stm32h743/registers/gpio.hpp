// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/stm32h743/registers/access.hpp"

/// Ports A to K: 16 pins each (reference manual, section GPIO; clocks in section RCC).

namespace sc::stm32h743::gpio {

enum class Port : std::uint32_t { a = 0, b, c, d, e, f, g, h, i, j, k };

[[nodiscard]] constexpr Address base(Port port) noexcept {
    return 0x58020000 + 0x400 * static_cast<std::uint32_t>(port);
}
inline constexpr Address kModer = 0x00;    ///< two bits a pin
inline constexpr Address kOtyper = 0x04;   ///< 0: push-pull
inline constexpr Address kOspeedr = 0x08;  ///< two bits a pin; 0 is the slowest
inline constexpr Address kPupdr = 0x0C;    ///< two bits a pin
inline constexpr Address kIdr = 0x10;
inline constexpr Address kBsrr = 0x18;  ///< low half sets, high half resets; set wins
inline constexpr Address kAfrh = 0x24;  ///< pins 8 to 15, four bits each

inline constexpr std::uint32_t kInput = 0;
inline constexpr std::uint32_t kOutput = 1;
inline constexpr std::uint32_t kAlternate = 2;
inline constexpr std::uint32_t kPullDown = 2;

inline constexpr Address kAhb4enr = 0x580244E0;
[[nodiscard]] constexpr std::uint32_t clock(Port port) noexcept { return 1U << static_cast<std::uint32_t>(port); }

}  // namespace sc::stm32h743::gpio
