// SPDX-License-Identifier: Apache-2.0
#include "firmware/sensors/modbus_rtu.hpp"

namespace sc::sensors::modbus {
namespace {

constexpr std::size_t kExceptionSize = 5;
constexpr std::size_t kWriteReplySize = 8;
constexpr std::size_t kReadOverhead = 5;

/// Sixteen steps of four bits: 32 bytes of table where a whole byte a step takes 512.
constexpr std::array<std::uint16_t, 16> crc_table() noexcept {
    std::array<std::uint16_t, 16> table{};
    for (unsigned i = 0; i < table.size(); ++i) {
        unsigned value = i;
        for (int bit = 0; bit < 4; ++bit) {
            value = (value >> 1U) ^ ((value & 1U) != 0 ? 0xA001U : 0U);
        }
        table[i] = static_cast<std::uint16_t>(value);
    }
    return table;
}
constexpr std::array<std::uint16_t, 16> kCrcTable = crc_table();

void put(Telegram& telegram, unsigned byte) noexcept {
    telegram.bytes[telegram.size] = static_cast<std::uint8_t>(byte & 0xFFU);
    ++telegram.size;
}
void put_word(Telegram& telegram, std::uint16_t word) noexcept {
    put(telegram, word >> 8U);
    put(telegram, word);
}
void close(Telegram& telegram, std::int64_t patience_ns) noexcept {
    const std::uint16_t sum = crc(telegram.view());
    put(telegram, sum);
    put(telegram, sum >> 8U);
    telegram.patience_ns = patience_ns;
    telegram.reply = telegram.bytes[0] == kBroadcast ? ReplyForm::none : ReplyForm::modbus;
}

bool reads(std::uint8_t function) noexcept { return function == kReadHolding || function == kReadInput; }

}  // namespace

std::uint16_t crc(std::span<const std::uint8_t> bytes) noexcept {
    unsigned state = 0xFFFFU;
    for (const std::uint8_t byte : bytes) {
        state ^= byte;
        state = (state >> 4U) ^ kCrcTable[state & 0xFU];
        state = (state >> 4U) ^ kCrcTable[state & 0xFU];
    }
    return static_cast<std::uint16_t>(state);
}

Telegram read(std::uint8_t address, std::uint8_t function, std::uint16_t first, std::uint8_t count,
              std::int64_t patience_ns) noexcept {
    Telegram telegram;
    put(telegram, address);
    put(telegram, function);
    put_word(telegram, first);
    put_word(telegram, count);
    close(telegram, patience_ns);
    return telegram;
}

Telegram write(std::uint8_t address, std::uint16_t reg, std::uint16_t value, std::int64_t patience_ns) noexcept {
    Telegram telegram;
    put(telegram, address);
    put(telegram, kWriteOne);
    put_word(telegram, reg);
    put_word(telegram, value);
    close(telegram, patience_ns);
    return telegram;
}

Telegram write_many(std::uint8_t address, std::uint16_t reg, std::uint16_t value, std::int64_t patience_ns) noexcept {
    Telegram telegram;
    put(telegram, address);
    put(telegram, kWriteMany);
    put_word(telegram, reg);
    put_word(telegram, 1);
    put(telegram, 2);
    put_word(telegram, value);
    close(telegram, patience_ns);
    return telegram;
}

std::size_t reply_size(std::span<const std::uint8_t> reply) noexcept {
    if (reply.size() < 3) {
        return 0;
    }
    if ((reply[1] & kExceptionBit) != 0) {
        return kExceptionSize;
    }
    return reads(reply[1]) ? kReadOverhead + reply[2] : kWriteReplySize;
}

SensorCode judge(std::span<const std::uint8_t> request, std::span<const std::uint8_t> reply,
                 std::uint8_t& detail) noexcept {
    const std::size_t body = reply.size() - 2;
    const std::uint16_t sum = crc(reply.first(body));
    if (reply[body] != (sum & 0xFFU) || reply[body + 1] != (sum >> 8U)) {
        return SensorCode::bad_crc;
    }
    if (reply[0] != request[0]) {
        detail = reply[0];
        return SensorCode::wrong_slave;
    }
    if (reply[1] == (request[1] | kExceptionBit)) {
        detail = reply[2];
        return SensorCode::exception;
    }
    if (reply[1] != request[1]) {
        return SensorCode::bad_frame;
    }
    if (reads(reply[1])) {
        return reply[2] == 2U * request[5] ? SensorCode::none : SensorCode::bad_frame;
    }
    for (std::size_t i = 2; i < 6; ++i) {
        if (reply[i] != request[i]) {
            return SensorCode::bad_frame;
        }
    }
    return SensorCode::none;
}

}  // namespace sc::sensors::modbus
