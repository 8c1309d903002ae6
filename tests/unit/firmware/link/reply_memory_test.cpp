// SPDX-License-Identifier: Apache-2.0
#include "firmware/link/reply_memory.hpp"

#include <gtest/gtest.h>

namespace {

using sc::Refusal;
using sc::link::ReplyMemory;
using Verdict = ReplyMemory::Verdict;

TEST(ReplyMemory, AnswersARepeatedRequestAgain) {
    ReplyMemory memory;
    EXPECT_EQ(memory.take(5), Verdict::fresh);
    EXPECT_EQ(memory.due(), nullptr);
    EXPECT_EQ(memory.take(5), Verdict::pending);
    memory.answer(5, Refusal::not_homed, -7);
    ASSERT_NE(memory.due(), nullptr);
    memory.sent(5);
    EXPECT_EQ(memory.due(), nullptr);
    EXPECT_EQ(memory.take(5), Verdict::repeat);
    ASSERT_NE(memory.due(), nullptr);
    EXPECT_EQ(memory.due()->sequence, 5U);
    EXPECT_EQ(memory.due()->refusal, static_cast<std::uint16_t>(Refusal::not_homed));
    EXPECT_EQ(memory.due()->detail, -7);
}

TEST(ReplyMemory, TheFirstAnswerCountsAndUnknownOnesAreIgnored) {
    ReplyMemory memory;
    memory.answer(1, Refusal::none, 0);
    EXPECT_EQ(memory.due(), nullptr);
    EXPECT_EQ(memory.take(1), Verdict::fresh);
    memory.answer(1, Refusal::none, 1);
    memory.answer(1, Refusal::wrong_state, 2);
    EXPECT_EQ(memory.due()->refusal, 0U);
    EXPECT_EQ(memory.due()->detail, 1);
}

TEST(ReplyMemory, RemembersEightAndCallsOlderOnesStale) {
    ReplyMemory memory;
    for (std::uint32_t sequence = 1; sequence <= 9; ++sequence) {
        EXPECT_EQ(memory.take(sequence), Verdict::fresh);
        memory.answer(sequence, Refusal::none, sequence);
        memory.sent(sequence);
    }
    EXPECT_EQ(memory.take(1), Verdict::stale);
    for (std::uint32_t sequence = 2; sequence <= 9; ++sequence) {
        EXPECT_EQ(memory.take(sequence), Verdict::repeat) << sequence;
    }
    EXPECT_EQ(memory.newest(), 9U);
}

TEST(ReplyMemory, CallsARequestStaleThatWasOvertaken) {
    ReplyMemory memory;
    EXPECT_EQ(memory.take(6), Verdict::fresh);
    EXPECT_EQ(memory.take(5), Verdict::stale);
}

TEST(ReplyMemory, TakesNoNinthRequestWhileEightWait) {
    ReplyMemory memory;
    for (std::uint32_t sequence = 1; sequence <= 8; ++sequence) {
        EXPECT_EQ(memory.take(sequence), Verdict::fresh);
    }
    EXPECT_EQ(memory.take(9), Verdict::full);
    EXPECT_EQ(memory.newest(), 8U);
    memory.answer(1, Refusal::none, 0);
    EXPECT_EQ(memory.take(9), Verdict::fresh);
}

TEST(ReplyMemory, SequencesMayWrapAndStartAnywhere) {
    ReplyMemory memory;
    for (const std::uint32_t sequence : {0xFFFFFFFEU, 0xFFFFFFFFU, 0U, 1U}) {
        EXPECT_EQ(memory.take(sequence), Verdict::fresh);
    }
    EXPECT_EQ(memory.take(0xFFFFFFFDU), Verdict::stale);
    EXPECT_EQ(ReplyMemory{}.take(0), Verdict::fresh);
}

TEST(ReplyMemory, GivesTheOldestDueFirst) {
    ReplyMemory memory;
    for (std::uint32_t sequence = 1; sequence <= 12; ++sequence) {
        static_cast<void>(memory.take(sequence));
        memory.answer(sequence, Refusal::none, 0);
    }
    for (std::uint32_t sequence = 5; sequence <= 12; ++sequence) {
        ASSERT_NE(memory.due(), nullptr);
        EXPECT_EQ(memory.due()->sequence, sequence);
        memory.sent(sequence);
    }
}

}  // namespace
