// SPDX-License-Identifier: Apache-2.0
#include "shared/wire/bytes.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace {

using sc::ByteReader;
using sc::ByteWriter;

TEST(ByteWriter, WritesLittleEndian) {
    std::array<std::uint8_t, 15> bytes{};
    ByteWriter writer(bytes);
    writer.put(std::uint8_t{0x01});
    writer.put(std::uint16_t{0x0302});
    writer.put(std::int32_t{-2});
    writer.put(1.0);
    const std::array<std::uint8_t, 15> expected{1, 2, 3, 0xFE, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F};
    EXPECT_TRUE(writer.ok());
    EXPECT_EQ(writer.size(), bytes.size());
    EXPECT_EQ(bytes, expected);
}

TEST(ByteWriter, WritesNothingPastTheEndNorAfterIt) {
    std::array<std::uint8_t, 6> bytes{0xAA, 0xAA, 0xAA, 0xAA, 0xAA, 0xAA};
    ByteWriter writer{std::span(bytes).first(5)};
    writer.put(std::uint32_t{0});
    writer.put(std::uint16_t{0});
    EXPECT_FALSE(writer.ok());
    writer.put(std::uint8_t{0});
    EXPECT_FALSE(writer.ok());
    EXPECT_EQ(writer.size(), 4U);
    EXPECT_EQ(bytes[4], 0xAA);
    EXPECT_EQ(bytes[5], 0xAA);
}

TEST(ByteReader, ReturnsWhatWasWritten) {
    std::array<std::uint8_t, 40> bytes{};
    ByteWriter writer(bytes);
    writer.put(std::numeric_limits<std::int64_t>::min());
    writer.put(std::numeric_limits<std::uint64_t>::max());
    writer.put(-0.1);
    writer.put(std::int32_t{-7});
    const std::vector<std::uint8_t> tail{9, 8, 7};
    writer.put_bytes(tail);
    ByteReader reader(writer.written());
    EXPECT_EQ(reader.get<std::int64_t>(), std::numeric_limits<std::int64_t>::min());
    EXPECT_EQ(reader.get<std::uint64_t>(), std::numeric_limits<std::uint64_t>::max());
    EXPECT_EQ(reader.get<double>(), -0.1);
    EXPECT_EQ(reader.get<std::int32_t>(), -7);
    const auto rest = reader.get_bytes(3);
    EXPECT_EQ(std::vector<std::uint8_t>(rest.begin(), rest.end()), tail);
    EXPECT_TRUE(reader.exhausted());
}

TEST(ByteReader, ReadsZeroPastTheEndAndRemembersIt) {
    const std::array<std::uint8_t, 3> bytes{1, 2, 3};
    ByteReader reader(bytes);
    EXPECT_EQ(reader.get<std::uint32_t>(), 0U);
    EXPECT_FALSE(reader.ok());
    EXPECT_EQ(reader.get<std::uint8_t>(), 0U);
    EXPECT_TRUE(reader.get_bytes(1).empty());
    EXPECT_FALSE(reader.exhausted());
}

TEST(ByteReader, IsNotExhaustedWithBytesLeft) {
    const std::array<std::uint8_t, 2> bytes{1, 2};
    ByteReader reader(bytes);
    EXPECT_EQ(reader.get<std::uint8_t>(), 1U);
    EXPECT_TRUE(reader.ok());
    EXPECT_FALSE(reader.exhausted());
    EXPECT_EQ(reader.remaining(), 1U);
}

}  // namespace
