// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/sensors/telegram.hpp"

/// Telegrams of Modbus RTU (Modbus over serial line 1.02): building requests, judging answers. Pure; any context; some
/// 15 instructions a byte.

namespace sc::sensors::modbus {

inline constexpr std::uint8_t kReadHolding = 3;
inline constexpr std::uint8_t kReadInput = 4;
inline constexpr std::uint8_t kWriteOne = 6;
inline constexpr std::uint8_t kWriteMany = 16;
inline constexpr std::uint8_t kBroadcast = 0;
inline constexpr std::uint8_t kExceptionBit = 0x80;

/// CRC-16, polynomial 0x8005 reflected (0xA001), start 0xFFFF; goes low byte first.
[[nodiscard]] std::uint16_t crc(std::span<const std::uint8_t> bytes) noexcept;

/// `function` is kReadHolding or kReadInput; 1 to 16 registers.
[[nodiscard]] Telegram read(std::uint8_t address, std::uint8_t function, std::uint16_t first, std::uint8_t count,
                            std::int64_t patience_ns) noexcept;
/// A write to address 0 is a broadcast, which nobody answers.
[[nodiscard]] Telegram write(std::uint8_t address, std::uint16_t reg, std::uint16_t value,
                             std::int64_t patience_ns) noexcept;
/// The same with function 16, for sensors that know no function 6.
[[nodiscard]] Telegram write_many(std::uint8_t address, std::uint16_t reg, std::uint16_t value,
                                  std::int64_t patience_ns) noexcept;

/// Size of the whole answer as its first bytes tell it; 0 while they do not yet.
[[nodiscard]] std::size_t reply_size(std::span<const std::uint8_t> reply) noexcept;

/// Whether a whole answer belongs to the request; `detail` as in Reply.
[[nodiscard]] SensorCode judge(std::span<const std::uint8_t> request, std::span<const std::uint8_t> reply,
                               std::uint8_t& detail) noexcept;

/// Register `i` of a checked answer to a read.
[[nodiscard]] constexpr std::uint16_t register_of(std::span<const std::uint8_t> reply, std::size_t i) noexcept {
    return static_cast<std::uint16_t>(reply[3 + 2 * i] << 8U | reply[4 + 2 * i]);
}

}  // namespace sc::sensors::modbus
