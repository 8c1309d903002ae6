// SPDX-License-Identifier: Apache-2.0
#include "shared/link/can_framing.hpp"

#include <algorithm>
#include <cstdint>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace {

using sc::link::CanReassembler;
using sc::link::CanSegmenter;
using sc::link::LinkCanFrame;
using Buffer = std::vector<std::uint8_t>;

Buffer message_of(std::size_t size, unsigned seed = 1) {
    Buffer out(size);
    for (std::size_t i = 0; i < size; ++i) {
        out[i] = static_cast<std::uint8_t>(i * 7 + seed);
    }
    return out;
}
std::vector<LinkCanFrame> cut(CanSegmenter& segmenter, const Buffer& message) {
    EXPECT_TRUE(segmenter.begin(message));
    std::vector<LinkCanFrame> frames;
    LinkCanFrame frame;
    while (segmenter.next(frame)) {
        frames.push_back(frame);
    }
    return frames;
}
std::vector<Buffer> join(CanReassembler& reassembler, const std::vector<LinkCanFrame>& frames) {
    std::vector<Buffer> out;
    for (const LinkCanFrame& frame : frames) {
        if (const auto message = reassembler.push(frame)) {
            out.emplace_back(message->begin(), message->end());
        }
    }
    return out;
}

class CanFraming : public testing::TestWithParam<bool> {
protected:
    CanSegmenter segmenter{0x123, GetParam()};
    CanReassembler reassembler;
};

TEST_P(CanFraming, EveryLengthComesBackInLegalFrames) {
    const std::set<unsigned> legal = GetParam() ? std::set<unsigned>{1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64}
                                                : std::set<unsigned>{1, 2, 3, 4, 5, 6, 7, 8};
    for (std::size_t size = 1; size <= sc::link::kMessageCapacity; ++size) {
        const Buffer message = message_of(size);
        const auto frames = cut(segmenter, message);
        for (const LinkCanFrame& frame : frames) {
            EXPECT_TRUE(legal.contains(frame.size)) << unsigned{frame.size};
            EXPECT_EQ(frame.id, 0x123U);
            EXPECT_EQ(frame.fd, GetParam());
        }
        EXPECT_EQ(join(reassembler, frames), std::vector<Buffer>{message}) << size;
    }
    EXPECT_EQ(reassembler.messages_dropped(), 0U);
    EXPECT_EQ(reassembler.gaps(), 0U);
}

TEST_P(CanFraming, OneLostFrameDropsItsMessageAndNoOther) {
    const Buffer before = message_of(100, 1);
    const Buffer hit = message_of(200, 2);
    const Buffer after = message_of(150, 3);
    const std::size_t count = cut(segmenter, hit).size();
    for (std::size_t lost = 0; lost < count; ++lost) {
        CanSegmenter out(1, GetParam());
        CanReassembler in;
        EXPECT_EQ(join(in, cut(out, before)), std::vector<Buffer>{before});
        auto frames = cut(out, hit);
        frames.erase(frames.begin() + static_cast<std::ptrdiff_t>(lost));
        EXPECT_TRUE(join(in, frames).empty()) << lost;
        EXPECT_EQ(join(in, cut(out, after)), std::vector<Buffer>{after}) << lost;
        EXPECT_EQ(in.gaps(), 1U);
        EXPECT_EQ(in.messages_dropped(), 1U) << lost;
    }
}

TEST_P(CanFraming, AFrameThatComesTwiceChangesNothing) {
    const Buffer message = message_of(247);
    std::vector<LinkCanFrame> twice;
    for (const LinkCanFrame& frame : cut(segmenter, message)) {
        twice.push_back(frame);
        twice.push_back(frame);
    }
    EXPECT_EQ(join(reassembler, twice), std::vector<Buffer>{message});
    EXPECT_EQ(reassembler.frames_repeated(), twice.size() / 2);
}

TEST_P(CanFraming, AStartInsideAMessageDropsIt) {
    auto frames = cut(segmenter, message_of(247, 1));
    frames.resize(2);
    // The second message starts where the first was broken off, with the sequence that follows.
    CanSegmenter other(0x123, GetParam());
    static_cast<void>(cut(other, message_of(GetParam() ? 100 : 10, 0)));
    const Buffer second = message_of(20, 9);
    for (const LinkCanFrame& frame : cut(other, second)) {
        frames.push_back(frame);
    }
    EXPECT_EQ(join(reassembler, frames), std::vector<Buffer>{second});
    EXPECT_EQ(reassembler.gaps(), 0U);
    EXPECT_EQ(reassembler.messages_dropped(), 1U);
}

TEST_P(CanFraming, RefusesEmptyTooLongAndSecondMessages) {
    EXPECT_FALSE(segmenter.begin({}));
    EXPECT_FALSE(segmenter.begin(message_of(sc::link::kMessageCapacity + 1)));
    EXPECT_TRUE(segmenter.begin(message_of(10)));
    EXPECT_FALSE(segmenter.begin(message_of(10)));
    EXPECT_TRUE(segmenter.busy());
}

TEST_P(CanFraming, JoiningInMidMessageWaitsForAStart) {
    auto frames = cut(segmenter, message_of(247, 1));
    frames.erase(frames.begin());
    const Buffer second = message_of(30, 5);
    for (const LinkCanFrame& frame : cut(segmenter, second)) {
        frames.push_back(frame);
    }
    EXPECT_EQ(join(reassembler, frames), std::vector<Buffer>{second});
}

INSTANTIATE_TEST_SUITE_P(ClassicAndFd, CanFraming, testing::Bool(),
                         [](const auto& carrier) { return carrier.param ? "Fd" : "Classic"; });

LinkCanFrame frame_of(std::initializer_list<std::uint8_t> bytes, bool fd = false) {
    LinkCanFrame frame;
    frame.fd = fd;
    frame.size = static_cast<std::uint8_t>(bytes.size());
    std::copy(bytes.begin(), bytes.end(), frame.data.begin());
    return frame;
}

TEST(CanReassembler, RefusesFramesThatContradictTheLength) {
    const std::vector<LinkCanFrame> wrong{
        frame_of({}),               // no header
        frame_of({0xC0}),           // start without a length
        frame_of({0xC0, 0, 1}),     // length 0
        frame_of({0xC0, 248, 1}),   // longer than any message
        frame_of({0xC0, 3, 1, 2}),  // ends too early
        frame_of({0xC0, 1, 1, 2}),  // classic frames are not padded
        frame_of({0x80, 2, 1, 2}),  // complete, but no end
        frame_of({0x40, 1, 1}),     // end without a start
    };
    for (const LinkCanFrame& frame : wrong) {
        CanReassembler in;
        EXPECT_FALSE(in.push(frame).has_value());
        EXPECT_EQ(in.messages_dropped(), 1U);
        const auto good = in.push(frame_of({0xC1, 2, 8, 9}));
        ASSERT_TRUE(good.has_value());
        EXPECT_EQ(Buffer(good->begin(), good->end()), (Buffer{8, 9}));
    }
    LinkCanFrame too_long;
    too_long.size = 9;
    EXPECT_FALSE(CanReassembler{}.push(too_long).has_value());
    too_long.fd = true;
    too_long.size = 65;
    EXPECT_FALSE(CanReassembler{}.push(too_long).has_value());
}

TEST(CanReassembler, TakesThePaddingOffAnFdFrame) {
    CanReassembler in;
    const auto message = in.push(frame_of({0xC5, 8, 1, 2, 3, 4, 5, 6, 7, 8, 0, 0}, true));
    ASSERT_TRUE(message.has_value());
    EXPECT_EQ(Buffer(message->begin(), message->end()), (Buffer{1, 2, 3, 4, 5, 6, 7, 8}));
}

TEST(CanSegmenter, FillsFramesToTheLastByte) {
    CanSegmenter classic(1, false);
    EXPECT_EQ(cut(classic, message_of(247)).size(), 36U);
    CanSegmenter fd(1, true);
    EXPECT_EQ(cut(fd, message_of(247)).size(), 4U);
    EXPECT_EQ(sc::link::legal_can_size(65), 64U);
    EXPECT_EQ(sc::link::legal_can_size(9), 12U);
}

}  // namespace
