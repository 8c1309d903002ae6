// SPDX-License-Identifier: Apache-2.0
#include "shared/link/cobs.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace {

using Buffer = std::vector<std::uint8_t>;
using sc::link::cobs_capacity;
using sc::link::cobs_encode;
using Decoder = sc::link::CobsDecoder<600>;

Buffer encoded(const Buffer& frame) {
    Buffer out(cobs_capacity(frame.size()));
    const std::size_t size = cobs_encode(frame, out);
    EXPECT_GT(size, 0U);
    out.resize(size);
    return out;
}
template <class D>
std::vector<Buffer> frames(D& decoder, const Buffer& bytes) {
    std::vector<Buffer> out;
    for (const std::uint8_t byte : bytes) {
        if (const auto frame = decoder.push(byte)) {
            out.emplace_back(frame->begin(), frame->end());
        }
    }
    return out;
}
Buffer counting(std::size_t first, std::size_t size) {
    Buffer out(size);
    for (std::size_t i = 0; i < size; ++i) {
        out[i] = static_cast<std::uint8_t>(first + i);
    }
    return out;
}

TEST(Cobs, GivesThePublishedExamples) {
    EXPECT_EQ(encoded({}), (Buffer{1, 0}));
    EXPECT_EQ(encoded({0}), (Buffer{1, 1, 0}));
    EXPECT_EQ(encoded({0, 0}), (Buffer{1, 1, 1, 0}));
    EXPECT_EQ(encoded({0x11, 0x22, 0x00, 0x33}), (Buffer{3, 0x11, 0x22, 2, 0x33, 0}));
    EXPECT_EQ(encoded({0x11, 0x00, 0x00, 0x00}), (Buffer{2, 0x11, 1, 1, 1, 0}));
}

TEST(Cobs, Gives254BytesOneFullGroup) {
    const Buffer run = counting(1, 254);
    Buffer expected(256, 0);
    expected[0] = 0xFF;
    std::copy(run.begin(), run.end(), expected.begin() + 1);
    EXPECT_EQ(encoded(run), expected);
    Buffer longer(258, 0);
    std::copy(expected.begin(), expected.end(), longer.begin());
    longer[255] = 2;
    longer[256] = 0xFF;
    EXPECT_EQ(encoded(counting(1, 255)), longer);
}

TEST(Cobs, ComesBackAroundTheGroupSizeWithAndWithoutZeros) {
    for (std::size_t size = 0; size < 520; ++size) {
        for (const std::size_t first : {std::size_t{0}, std::size_t{1}, std::size_t{100}}) {
            Decoder decoder;
            const Buffer frame = counting(first, size);
            const auto back = frames(decoder, encoded(frame));
            ASSERT_EQ(back.size(), 1U);
            EXPECT_EQ(back[0], frame);
        }
    }
}

TEST(Cobs, EncodedHasItsOnlyZeroAtTheEnd) {
    for (std::size_t size = 0; size < 520; ++size) {
        const Buffer bytes = encoded(counting(250, size));
        EXPECT_LE(bytes.size(), cobs_capacity(size));
        for (std::size_t i = 0; i + 1 < bytes.size(); ++i) {
            ASSERT_NE(bytes[i], 0);
        }
        EXPECT_EQ(bytes.back(), 0);
    }
}

TEST(Cobs, RefusesEverySpanThatIsTooShortAndWritesNotPastIt) {
    for (const Buffer& frame : {Buffer{1, 0, 2, 3, 0}, counting(1, 254), counting(1, 300), Buffer{}}) {
        const std::size_t needed = encoded(frame).size();
        for (std::size_t room = 0; room < needed; ++room) {
            Buffer out(room + 1, 0xAA);
            EXPECT_EQ(cobs_encode(frame, std::span(out).first(room)), 0U);
            EXPECT_EQ(out[room], 0xAA);
        }
    }
}

TEST(CobsDecoder, IgnoresDelimitersBetweenFrames) {
    Decoder decoder;
    EXPECT_EQ(frames(decoder, {0, 0, 2, 7, 0, 0, 2, 8, 0}), (std::vector<Buffer>{{7}, {8}}));
    EXPECT_EQ(decoder.frames_bad(), 0U);
}

TEST(CobsDecoder, TakesFramesInPortions) {
    Decoder decoder;
    EXPECT_TRUE(frames(decoder, {3, 7}).empty());
    EXPECT_TRUE(frames(decoder, {9}).empty());
    EXPECT_EQ(frames(decoder, {0}), (std::vector<Buffer>{{7, 9}}));
}

TEST(CobsDecoder, CountsACutFrameAndTakesTheNext) {
    Decoder decoder;
    EXPECT_EQ(frames(decoder, {5, 1, 2, 0, 2, 9, 0}), (std::vector<Buffer>{{9}}));
    EXPECT_EQ(decoder.frames_bad(), 1U);
}

TEST(CobsDecoder, CountsATooLongFrameOnceAndTakesTheNext) {
    sc::link::CobsDecoder<4> decoder;
    const Buffer fits = encoded({1, 2, 0, 4});
    const Buffer too_long = encoded({1, 2, 0, 4, 5});
    const Buffer much_too_long = encoded(Buffer(500, 1));
    EXPECT_EQ(frames(decoder, too_long).size(), 0U);
    EXPECT_EQ(frames(decoder, much_too_long).size(), 0U);
    EXPECT_EQ(decoder.frames_bad(), 2U);
    EXPECT_EQ(frames(decoder, fits).size(), 1U);
}

}  // namespace
