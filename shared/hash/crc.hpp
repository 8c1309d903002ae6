// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// Cyclic redundancy checks, one table look-up a byte. Callable from any context.

namespace sc {

namespace crc_detail {

constexpr std::array<std::uint32_t, 256> crc32_table() noexcept {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < 256; ++i) {
        std::uint32_t value = i;
        for (int bit = 0; bit < 8; ++bit) {
            value = (value >> 1U) ^ ((value & 1U) != 0 ? 0xEDB88320U : 0U);
        }
        table[i] = value;
    }
    return table;
}
inline constexpr std::array<std::uint32_t, 256> kCrc32Table = crc32_table();

}  // namespace crc_detail

/// CRC-32 of IEEE 802.3 (polynomial 0x04C11DB7 reflected, start and end inverted), in steps of any size.
class Crc32 {
public:
    constexpr Crc32& update(std::span<const std::uint8_t> bytes) noexcept {
        std::uint32_t state = state_;  // bytes may alias anything: a member would be stored at every step
        for (const std::uint8_t byte : bytes) {
            state = (state >> 8U) ^ crc_detail::kCrc32Table[(state ^ byte) & 0xFFU];
        }
        state_ = state;
        return *this;
    }
    [[nodiscard]] constexpr std::uint32_t value() const noexcept { return ~state_; }

private:
    std::uint32_t state_ = 0xFFFFFFFFU;
};

[[nodiscard]] constexpr std::uint32_t crc32(std::span<const std::uint8_t> bytes) noexcept {
    return Crc32{}.update(bytes).value();
}

/// CRC-16 with polynomial 0x1021, start 0xFFFF, not reflected, not inverted. Bit by bit: for short records only.
[[nodiscard]] constexpr std::uint16_t crc16(std::span<const std::uint8_t> bytes) noexcept {
    std::uint32_t state = 0xFFFFU;
    for (const std::uint8_t byte : bytes) {
        state ^= std::uint32_t{byte} << 8U;
        for (int bit = 0; bit < 8; ++bit) {
            state = (state << 1U) ^ ((state & 0x8000U) != 0 ? 0x1021U : 0U);
        }
    }
    return static_cast<std::uint16_t>(state & 0xFFFFU);
}

}  // namespace sc
