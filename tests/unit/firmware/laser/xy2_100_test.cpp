// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/xy2_100.hpp"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

namespace sc::laser {
namespace {

/// Reads a frame bit by bit as a head of this format would: control bits, data, parity over the nineteen before it
/// (even over all twenty for 16 bits, odd for 18). Shares nothing with the encoder.
int decode(std::uint32_t word, GalvoWord format) {
    std::string bits;
    for (int bit = 31; bit >= 0; --bit) {
        bits += ((word >> static_cast<unsigned>(bit)) & 1U) != 0 ? '1' : '0';
    }
    EXPECT_EQ(bits.substr(0, 12), "000000000000") << "more than twenty bits";
    bits = bits.substr(12);
    const bool wide = format == GalvoWord::bits18;
    const std::size_t control = wide ? 1 : 3;
    EXPECT_EQ(bits.substr(0, control), wide ? "1" : "001");
    const auto ones = std::count(bits.begin(), bits.end(), '1');
    EXPECT_EQ(ones % 2, wide ? 1 : 0) << "parity of " << bits;
    return std::stoi(bits.substr(control, 19 - control), nullptr, 2);
}

TEST(Xy2100, All65536WordsReadBackInBothConventions) {
    for (int p = -32768; p <= 32767; ++p) {
        ASSERT_EQ(decode(xy2_100_word(p, GalvoConvention::offset_binary), GalvoWord::bits16), p + 32768);
        ASSERT_EQ(decode(xy2_100_word(p, GalvoConvention::twos_complement), GalvoWord::bits16), p & 0xFFFF);
    }
}

TEST(Xy2100, All262144WordsOfEighteenBitsReadBackInBothConventions) {
    for (int p = -131'072; p <= 131'071; ++p) {
        const auto word = [p](GalvoConvention c) { return xy2_100_word(p, c, GalvoWord::bits18); };
        ASSERT_EQ(decode(word(GalvoConvention::offset_binary), GalvoWord::bits18), p + 131'072);
        ASSERT_EQ(decode(word(GalvoConvention::twos_complement), GalvoWord::bits18), p & 0x3FFFF);
    }
}

TEST(Xy2100, AFormatReadsItsOwnWords) {
    for (const GalvoWord word : {GalvoWord::bits16, GalvoWord::bits18}) {
        for (const GalvoConvention convention : {GalvoConvention::offset_binary, GalvoConvention::twos_complement}) {
            const WordFormat format(word, convention);
            for (int p = -format.most(); p <= format.most(); p += 7) {
                ASSERT_EQ(format.position(format.word(p)), p);
            }
        }
    }
}

TEST(Xy2100, BothWordsAtOnceAreTheClampedWords) {
    for (const GalvoWord word : {GalvoWord::bits16, GalvoWord::bits18}) {
        for (const GalvoConvention convention : {GalvoConvention::offset_binary, GalvoConvention::twos_complement}) {
            const WordFormat format(word, convention);
            const int wide = format.most() + 5'000;
            for (int x = -wide; x <= wide; ++x) {
                const int z = (x * 37) % wide;
                const auto both = word == GalvoWord::bits16 ? format.clamped_words<GalvoWord::bits16>(x, z)
                                                            : format.clamped_words<GalvoWord::bits18>(x, z);
                ASSERT_EQ(both[0], format.word(format.within(x))) << x << ' ' << z;
                ASSERT_EQ(both[1], format.word(format.within(z))) << x << ' ' << z;
            }
            const int most = 2'147'483'647;
            const auto ends = word == GalvoWord::bits16 ? format.clamped_words<GalvoWord::bits16>(most, -most - 1)
                                                        : format.clamped_words<GalvoWord::bits18>(most, -most - 1);
            EXPECT_EQ(ends[0], format.word(format.most()));
            EXPECT_EQ(ends[1], format.word(-format.most()));
        }
    }
}

TEST(Xy2100, KnownFrames) {
    const auto word = [](int wire) { return xy2_100_word(wire, GalvoConvention::twos_complement); };
    EXPECT_EQ(word(0x0000), 0x20001U);
    EXPECT_EQ(word(0x1234), 0x22468U);
    EXPECT_EQ(word(0x7FFF), 0x2FFFEU);
    EXPECT_EQ(word(0x8000), 0x30000U);
    EXPECT_EQ(word(0xC000), 0x38001U);
    EXPECT_EQ(word(0xFFFF), 0x3FFFFU);
    EXPECT_EQ(xy2_100_word(0x20000, GalvoConvention::twos_complement, GalvoWord::bits18), 0xC0001U);
}

}  // namespace
}  // namespace sc::laser
