// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/xy2_100.hpp"

#include <gtest/gtest.h>

namespace sc::laser {
namespace {

/// Reads a frame bit by bit as a head would: control 001, sixteen data bits, parity over the nineteen before it.
int decode(std::uint32_t word) {
    int ones = 0;
    int data = 0;
    for (int bit = 19; bit >= 0; --bit) {
        const int value = static_cast<int>((word >> static_cast<unsigned>(bit)) & 1U);
        if (bit > 0) {
            ones += value;
        }
        if (bit >= 17) {
            EXPECT_EQ(value, bit == 17 ? 1 : 0) << "control bits";
        } else if (bit >= 1) {
            data = data * 2 + value;
        } else {
            EXPECT_EQ(value, ones % 2) << "parity";
        }
    }
    return data;
}

TEST(Xy2100, AllWordsReadBackInBothConventions) {
    for (int p = -32768; p <= 32767; ++p) {
        const auto position = static_cast<std::int16_t>(p);
        ASSERT_EQ(decode(xy2_100_word(position, GalvoConvention::offset_binary)), p + 32768);
        ASSERT_EQ(decode(xy2_100_word(position, GalvoConvention::twos_complement)), p & 0xFFFF);
    }
}

TEST(Xy2100, KnownFrames) {
    const auto word = [](int wire) {
        return xy2_100_word(static_cast<std::int16_t>(wire), GalvoConvention::twos_complement);
    };
    EXPECT_EQ(word(0x0000), 0x20001U);
    EXPECT_EQ(word(0x1234), 0x22468U);
    EXPECT_EQ(word(0x7FFF), 0x2FFFEU);
    EXPECT_EQ(word(0x8000), 0x30000U);
    EXPECT_EQ(word(0xC000), 0x38001U);
    EXPECT_EQ(word(0xFFFF), 0x3FFFFU);
}

TEST(FieldMap, AppliesTheFieldCorrectionAndClamps) {
    Compensation c;
    c.galvo_from_field = {1.01, 0.002, -0.003, 0.99};
    c.galvo_offset = {-1e-4, 2e-4};
    GalvoConfig galvo;
    galvo.counts_per_metre = 1e6;
    galvo.convention = GalvoConvention::offset_binary;
    const FieldMap map(c, galvo);
    const auto counts = map.counts(0.01, -0.005);
    EXPECT_EQ(counts[0], 10'100 - 10 - 100);
    EXPECT_EQ(counts[1], -30 - 4'950 + 200);
    EXPECT_EQ(map.counts(1.0, -1.0)[0], 32767);
    EXPECT_EQ(map.counts(1.0, -1.0)[1], -32767);
    EXPECT_EQ(map.words(0.01, -0.005)[0], xy2_100_word(10'100 - 10 - 100, GalvoConvention::offset_binary));
    EXPECT_EQ(map.words(0.01, -0.005)[1], xy2_100_word(-30 - 4'950 + 200, GalvoConvention::offset_binary));
    EXPECT_EQ(map.words(-1.0, 1.0)[0], xy2_100_word(-32767, GalvoConvention::offset_binary));
}

}  // namespace
}  // namespace sc::laser
