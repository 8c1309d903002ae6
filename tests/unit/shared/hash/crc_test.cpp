// SPDX-License-Identifier: Apache-2.0
#include "shared/hash/crc.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace {

std::vector<std::uint8_t> bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

TEST(Crc32, GivesThePublishedCheckValue) { EXPECT_EQ(sc::crc32(bytes_of("123456789")), 0xCBF43926U); }

TEST(Crc32, OfNothingIsZero) { EXPECT_EQ(sc::crc32({}), 0U); }

TEST(Crc32, IsTheSameInStepsOfAnySize) {
    const auto data = bytes_of("the quick brown fox jumps over the lazy dog");
    for (std::size_t cut = 0; cut <= data.size(); ++cut) {
        sc::Crc32 crc;
        crc.update(std::span(data).first(cut)).update(std::span(data).subspan(cut));
        EXPECT_EQ(crc.value(), sc::crc32(data)) << "cut at " << cut;
    }
}

TEST(Crc32, TableAgreesWithTheBitwiseDefinition) {
    for (unsigned byte = 0; byte < 256; ++byte) {
        std::uint32_t state = 0xFFFFFFFFU ^ byte;
        for (int bit = 0; bit < 8; ++bit) {
            state = (state & 1U) != 0 ? (state >> 1U) ^ 0xEDB88320U : state >> 1U;
        }
        const std::array<std::uint8_t, 1> one{static_cast<std::uint8_t>(byte)};
        EXPECT_EQ(sc::crc32(one), ~state);
    }
}

TEST(Crc16, GivesThePublishedCheckValue) { EXPECT_EQ(sc::crc16(bytes_of("123456789")), 0x29B1U); }

TEST(Crc16, OfNothingIsItsStart) { EXPECT_EQ(sc::crc16({}), 0xFFFFU); }

TEST(Crc16, SeesEverySingleBit) {
    auto data = bytes_of("position 0001");
    const std::uint16_t right = sc::crc16(data);
    for (std::size_t bit = 0; bit < data.size() * 8; ++bit) {
        data[bit / 8] = static_cast<std::uint8_t>(data[bit / 8] ^ (1U << (bit % 8)));
        EXPECT_NE(sc::crc16(data), right) << "bit " << bit;
        data[bit / 8] = static_cast<std::uint8_t>(data[bit / 8] ^ (1U << (bit % 8)));
    }
}

}  // namespace
