// SPDX-License-Identifier: Apache-2.0
#include "shared/link/can_framing.hpp"

#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace {

using sc::link::CanReassembler;
using sc::link::CanSegmenter;
using sc::link::LinkCanFrame;
using Buffer = std::vector<std::uint8_t>;
using Random = std::mt19937_64;

/// A message that names itself in its bytes, so that no two are alike.
Buffer numbered(std::uint32_t number, std::size_t size) {
    Buffer out(size);
    for (std::size_t i = 0; i < size; ++i) {
        out[i] = static_cast<std::uint8_t>((number >> (8 * (i % 4))) + i / 4);
    }
    return out;
}

class CanFramingProperty : public testing::TestWithParam<bool> {};

TEST_P(CanFramingProperty, UnderLossAndRepetitionWholeMessagesArriveOnceInOrder) {
    Random random(11);  // NOLINT(cert-msc32-c,cert-msc51-cpp): a fixed seed repeats
    CanSegmenter segmenter(1, GetParam());
    CanReassembler reassembler;
    std::uint32_t arrived = 0;
    std::uint32_t spoilt = 0;
    constexpr std::uint32_t kMessages = 20'000;
    for (std::uint32_t number = 0; number < kMessages; ++number) {
        const Buffer message = numbered(number, 4 + random() % (sc::link::kMessageCapacity - 3));
        ASSERT_TRUE(segmenter.begin(message));
        LinkCanFrame frame;
        bool lost = false;
        std::vector<Buffer> got;
        while (segmenter.next(frame)) {
            if (random() % 100 == 0) {
                lost = true;
                continue;
            }
            const int copies = random() % 50 == 0 ? 2 : 1;
            for (int i = 0; i < copies; ++i) {
                if (const auto whole = reassembler.push(frame)) {
                    got.emplace_back(whole->begin(), whole->end());
                }
            }
        }
        spoilt += lost ? 1 : 0;
        ASSERT_EQ(got, lost ? std::vector<Buffer>{} : std::vector<Buffer>{message}) << number;
        arrived += static_cast<std::uint32_t>(got.size());
    }
    EXPECT_EQ(arrived + spoilt, kMessages);
    EXPECT_GT(spoilt, 100U);
    EXPECT_LE(reassembler.messages_dropped(), spoilt) << "messages lost whole, side by side, are one break";
    EXPECT_GE(reassembler.messages_dropped(), spoilt / 2);
}

TEST_P(CanFramingProperty, AnyFramesYieldOnlyMessagesWithinBounds) {
    Random random(12);  // NOLINT(cert-msc32-c,cert-msc51-cpp): a fixed seed repeats
    CanReassembler reassembler;
    std::uint32_t messages = 0;
    std::uint8_t sequence = 0;
    for (int round = 0; round < 300'000; ++round) {
        LinkCanFrame frame;
        frame.fd = GetParam();
        frame.size = static_cast<std::uint8_t>(random() % 70);
        for (std::uint8_t& byte : frame.data) {
            byte = static_cast<std::uint8_t>(random() % 2 == 0 ? random() % 16 : random());
        }
        // Mostly the right sequence, so that lengths are reached.
        frame.data[0] = static_cast<std::uint8_t>((random() & 0xC0U) | (random() % 20 == 0 ? random() % 64 : sequence));
        sequence = static_cast<std::uint8_t>((sequence + 1U) % 64U);
        if (const auto message = reassembler.push(frame)) {
            ASSERT_GE(message->size(), 1U);
            ASSERT_LE(message->size(), sc::link::kMessageCapacity);
            ++messages;
        }
    }
    EXPECT_GT(messages, 100U);
}

INSTANTIATE_TEST_SUITE_P(ClassicAndFd, CanFramingProperty, testing::Bool(),
                         [](const auto& carrier) { return carrier.param ? "Fd" : "Classic"; });

}  // namespace
