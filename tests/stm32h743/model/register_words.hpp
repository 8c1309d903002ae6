// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "tests/stm32h743/model/machine.hpp"

namespace sc::model {

/// Registers without a behaviour of their own, as those of clock gates.
class RegisterWords : public Peripheral {
public:
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override { return words_.at(offset / 4); }
    void write(std::uint32_t offset, std::uint32_t value, unsigned /*bytes*/) override {
        words_.at(offset / 4) = value;
    }
    [[nodiscard]] bool has(std::uint32_t offset, std::uint32_t bits) const {
        return (words_.at(offset / 4) & bits) == bits;
    }

private:
    std::array<std::uint32_t, 256> words_{};
};

/// Reset and clock control.
namespace rcc {
inline constexpr std::uint32_t kBase = 0x58024400;
inline constexpr std::uint32_t kSize = 0x200;
inline constexpr std::uint32_t kAhb1 = 0xD8;
inline constexpr std::uint32_t kDma1 = 1U << 0U;
inline constexpr std::uint32_t kApb1l = 0xE8;
inline constexpr std::uint32_t kUsart2 = 1U << 17U;
inline constexpr std::uint32_t kUsart3 = 1U << 18U;
inline constexpr std::uint32_t kApb1h = 0xEC;
inline constexpr std::uint32_t kFdcan = 1U << 8U;
inline constexpr std::uint32_t kApb2 = 0xF0;
inline constexpr std::uint32_t kUsart6 = 1U << 5U;
}  // namespace rcc

}  // namespace sc::model
