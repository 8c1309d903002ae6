// SPDX-License-Identifier: Apache-2.0
#include "firmware/sensors/modbus_rtu.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace sc;
using namespace sc::sensors;

std::vector<std::uint8_t> bytes_of(const Telegram& t) { return {t.view().begin(), t.view().end()}; }

/// An answer with its checksum.
std::vector<std::uint8_t> summed(std::vector<std::uint8_t> bytes) {
    const std::uint16_t sum = modbus::crc(bytes);
    bytes.push_back(static_cast<std::uint8_t>(sum & 0xFFU));
    bytes.push_back(static_cast<std::uint8_t>(sum >> 8U));
    return bytes;
}

SensorCode judged(const Telegram& request, const std::vector<std::uint8_t>& reply, std::uint8_t& detail) {
    return modbus::judge(request.view(), reply, detail);
}

TEST(ModbusRtu, ChecksumIsTheStandards) {
    // Modbus over serial line 1.02, 6.2.2: device 02, function 07 gives 41 12.
    const std::vector<std::uint8_t> example{0x02, 0x07};
    EXPECT_EQ(modbus::crc(example), 0x1241);
    // CRC-16/MODBUS of "123456789" in the catalogue of parametrised CRC algorithms.
    const std::string text = "123456789";
    const std::vector<std::uint8_t> digits(text.begin(), text.end());
    EXPECT_EQ(modbus::crc(digits), 0x4B37);
}

TEST(ModbusRtu, RequestsAreWhatTheStandardSays) {
    EXPECT_EQ(bytes_of(modbus::read(0x11, 3, 0x006B, 3, 1)),
              (std::vector<std::uint8_t>{0x11, 0x03, 0x00, 0x6B, 0x00, 0x03, 0x76, 0x87}));
    EXPECT_EQ(bytes_of(modbus::write(0x11, 0x0001, 0x0003, 1)),
              (std::vector<std::uint8_t>{0x11, 0x06, 0x00, 0x01, 0x00, 0x03, 0x9A, 0x9B}));
    EXPECT_EQ(bytes_of(modbus::write_many(1, 3, 1, 1)).size(), 11U);
    EXPECT_EQ(modbus::write(0, 41, 1, 1).reply, ReplyForm::none);
}

TEST(ModbusRtu, TheLengthOfAnAnswerIsKnownFromItsThirdByte) {
    const std::vector<std::uint8_t> two{1, 3};
    const std::vector<std::uint8_t> read{1, 3, 4};
    const std::vector<std::uint8_t> wrote{1, 6, 0};
    const std::vector<std::uint8_t> refused{1, 0x84, 2};
    EXPECT_EQ(modbus::reply_size(two), 0U);
    EXPECT_EQ(modbus::reply_size(read), 9U);
    EXPECT_EQ(modbus::reply_size(wrote), 8U);
    EXPECT_EQ(modbus::reply_size(refused), 5U);
}

TEST(ModbusRtu, EveryWayInWhichAnAnswerMayBeWrongHasItsCode) {
    const Telegram request = modbus::read(5, 4, 6, 1, 1);
    std::uint8_t detail = 0;
    const auto good = summed({5, 4, 2, 0x12, 0x34});
    EXPECT_EQ(judged(request, good, detail), SensorCode::none);
    EXPECT_EQ(modbus::register_of(good, 0), 0x1234);
    EXPECT_EQ(judged(request, summed({6, 4, 2, 0x12, 0x34}), detail), SensorCode::wrong_slave);
    EXPECT_EQ(detail, 6);
    EXPECT_EQ(judged(request, summed({5, 0x84, 2}), detail), SensorCode::exception);
    EXPECT_EQ(detail, 2);
    EXPECT_EQ(judged(request, summed({5, 3, 2, 0x12, 0x34}), detail), SensorCode::bad_frame);
    EXPECT_EQ(judged(request, summed({5, 4, 4, 0, 0, 0, 0}), detail), SensorCode::bad_frame);
    EXPECT_EQ(judged(request, summed({5, 0x83, 2}), detail), SensorCode::bad_frame);
    const Telegram write = modbus::write(5, 10, 1, 1);
    EXPECT_EQ(judged(write, summed({5, 6, 0, 10, 0, 1}), detail), SensorCode::none);
    EXPECT_EQ(judged(write, summed({5, 6, 0, 10, 0, 0}), detail), SensorCode::bad_frame);
}

TEST(ModbusRtu, UpToThreeWrongBitsAreAlwaysFound) {
    // 7 bytes: 56 bits, 27 720 triples.
    const Telegram request = modbus::read(5, 4, 6, 1, 1);
    const auto good = summed({5, 4, 2, 0x12, 0x34});
    std::uint8_t detail = 0;
    int tried = 0;
    const auto flip = [](std::vector<std::uint8_t>& bytes, unsigned bit) {
        bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << bit % 8));
    };
    for (unsigned a = 0; a < 56; ++a) {
        for (unsigned b = a; b < 56; ++b) {
            for (unsigned c = b; c < 56; ++c) {
                if ((a == b) != (b == c)) {
                    continue;
                }
                auto bad = good;
                flip(bad, a);
                if (a != b) {
                    flip(bad, b);
                    flip(bad, c);
                }
                ASSERT_NE(judged(request, bad, detail), SensorCode::none) << a << ' ' << b << ' ' << c;
                ++tried;
            }
        }
    }
    EXPECT_EQ(tried, 56 + 27'720);
}

}  // namespace
