// SPDX-License-Identifier: Apache-2.0
#include "firmware/link/job_stream.hpp"

#include <array>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "shared/link/blocks.hpp"

namespace {

using sc::Item;
using sc::Refusal;
using sc::link::Block;
using sc::link::JobStream;
using sc::link::make_block;
using Taken = JobStream::Taken;

std::vector<Item> turns(std::size_t count) {
    std::vector<Item> items;
    for (std::size_t i = 0; i < count; ++i) {
        items.emplace_back(sc::Turn{static_cast<std::int32_t>(i)});
    }
    return items;
}
Block part(const std::vector<Item>& items, std::uint32_t first, std::size_t count) {
    const std::vector<Item> head(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(first + count));
    return make_block(sc::job_hash(items), head, first);
}

class JobStreamTest : public testing::Test {
protected:
    void open(std::size_t count) {
        items = turns(count);
        stream->open(sc::job_hash(items), static_cast<std::uint32_t>(count));
    }
    /// Takes a block and reads all that is kept.
    Taken take(const Block& block) {
        const Taken taken = stream->take(block);
        stream->step(100'000);
        return taken;
    }
    std::unique_ptr<JobStream> stream = std::make_unique<JobStream>();
    std::vector<Item> items;
};

TEST_F(JobStreamTest, TakesItemsInOrderAndVerifiesTheHash) {
    open(10);
    EXPECT_EQ(take(part(items, 0, 6)), Taken::stored);
    EXPECT_FALSE(stream->hash_ok());
    EXPECT_EQ(take(part(items, 6, 4)), Taken::stored);
    EXPECT_TRUE(stream->hash_ok());
    for (const Item& item : items) {
        ASSERT_NE(stream->items().front(), nullptr);
        EXPECT_EQ(*stream->items().front(), item);
        stream->items().pop();
    }
}

TEST_F(JobStreamTest, TakesNothingTwiceAndNothingEarly) {
    open(10);
    EXPECT_EQ(take(part(items, 1, 2)), Taken::ahead);
    EXPECT_EQ(stream->blocks_ahead(), 1U);
    EXPECT_EQ(take(part(items, 0, 4)), Taken::stored);
    EXPECT_EQ(take(part(items, 1, 3)), Taken::known);
    EXPECT_EQ(stream->items_repeated(), 5U) << "the two that came ahead, and three again";
    EXPECT_EQ(take(part(items, 2, 5)), Taken::stored);
    EXPECT_EQ(stream->items_repeated(), 7U);
    EXPECT_EQ(stream->received(), 7U);
    EXPECT_EQ(stream->items().size(), 7U);
}

TEST_F(JobStreamTest, TakesWhatThereIsRoomFor) {
    const std::size_t capacity = sc::ItemQueue::capacity();
    open(capacity + 100);
    while (stream->received() + 30 < capacity) {
        ASSERT_EQ(take(part(items, stream->received(), 30)), Taken::stored);
    }
    const std::uint32_t first = stream->received();
    EXPECT_EQ(take(part(items, first, 40)), Taken::stored);
    EXPECT_EQ(stream->received(), capacity);
    EXPECT_EQ(take(part(items, stream->received(), 5)), Taken::known) << "it is kept, though not yet read";
    stream->items().pop();
    stream->step(100);
    EXPECT_EQ(stream->received(), capacity + 1);
}

TEST_F(JobStreamTest, KeepsAFewBlocksAndReadsThemAsSlowlyAsItIsTold) {
    open(100);
    for (std::uint32_t block = 0; block < JobStream::kKept; ++block) {
        EXPECT_EQ(stream->take(part(items, 5 * block, 5)), Taken::stored);
    }
    EXPECT_EQ(stream->take(part(items, 80, 5)), Taken::full);
    EXPECT_EQ(stream->received(), 0U);
    for (std::uint32_t step = 1; step <= 4; ++step) {
        stream->step(3);
        EXPECT_LE(stream->received(), 3 * step);
        EXPECT_GE(stream->received(), 2 * step) << "the end of a block costs a step too";
    }
    EXPECT_EQ(stream->take(part(items, 80, 5)), Taken::stored);
    stream->step(100);
    EXPECT_EQ(stream->received(), 85U);
}

TEST_F(JobStreamTest, KeepsWhatComesAheadAndListsTheGaps) {
    open(100);
    EXPECT_EQ(take(part(items, 10, 10)), Taken::ahead);
    EXPECT_EQ(take(part(items, 40, 5)), Taken::ahead);
    EXPECT_EQ(take(part(items, 20, 5)), Taken::ahead);
    std::array<JobStream::Gap, 4> gaps{};
    ASSERT_EQ(stream->missing(gaps), 2U);
    EXPECT_EQ(gaps[0].from, 0U);
    EXPECT_EQ(gaps[0].until, 10U);
    EXPECT_EQ(gaps[1].from, 25U);
    EXPECT_EQ(gaps[1].until, 40U);
    EXPECT_EQ(stream->received(), 0U);
    EXPECT_EQ(take(part(items, 0, 10)), Taken::stored);
    EXPECT_EQ(stream->received(), 25U);
    EXPECT_EQ(take(part(items, 25, 15)), Taken::stored);
    EXPECT_EQ(stream->received(), 45U);
    EXPECT_EQ(stream->missing(gaps), 0U);
    EXPECT_EQ(stream->items_repeated(), 0U);
}

TEST_F(JobStreamTest, ABlockThatClosesAGapAlwaysFindsRoom) {
    open(200);
    for (std::uint32_t i = 1; i < 40; ++i) {
        (void)stream->take(part(items, 5 * i, 5));
    }
    EXPECT_EQ(take(part(items, 0, 5)), Taken::stored);
    EXPECT_GE(stream->received(), 5U * (JobStream::kKept - 1));
}

TEST_F(JobStreamTest, WithAGapAllThatTheWindowInvitesFindsRoom) {
    constexpr std::uint32_t kCount = 40;
    open(3000);
    std::uint32_t at = 0;
    for (int i = 0; i < 20; ++i, at += kCount) {
        ASSERT_EQ(take(part(items, at, kCount)), Taken::stored);
    }
    ASSERT_GT(stream->window(), (JobStream::kKept / 2) * kCount);
    const std::uint32_t end = stream->received() + stream->window();
    for (std::uint32_t first = at + kCount; first + kCount <= end; first += kCount) {
        EXPECT_EQ(stream->take(part(items, first, kCount)), Taken::ahead) << "the block at " << first;
    }
    EXPECT_EQ(take(part(items, at, kCount)), Taken::stored) << "and what closes the gap";
}

TEST_F(JobStreamTest, TheWindowFollowsTheSizeOfTheBlocks) {
    open(3000);
    std::uint32_t at = 0;
    const auto window_after = [this, &at](std::uint32_t count, int blocks) {
        for (int i = 0; i < blocks; ++i, at += count) {
            (void)take(part(items, at, count));
        }
        return stream->window();
    };
    constexpr auto kPlaces = static_cast<std::uint32_t>(JobStream::kKept - 1);
    EXPECT_NEAR(window_after(40, 20), kPlaces * 40, kPlaces * 4);
    EXPECT_NEAR(window_after(10, 30), kPlaces * 10, kPlaces) << "and down again";
    stream->open(1, 100);
    EXPECT_EQ(stream->window(), kPlaces * 16) << "a guess, in the next job";
}

TEST_F(JobStreamTest, AQuestionShowsWhatIsMissingBeforeItAndTakesOnePlace) {
    open(100);
    EXPECT_EQ(take(part(items, 0, 10)), Taken::stored);
    Block question;
    question.job_low = stream->job_low();
    question.first = 30;
    for (int i = 0; i < 40; ++i) {
        (void)take(question);
    }
    std::array<JobStream::Gap, 4> gaps{};
    ASSERT_EQ(stream->missing(gaps), 1U);
    EXPECT_EQ(gaps[0].from, 10U);
    EXPECT_EQ(gaps[0].until, 30U);
    EXPECT_EQ(take(part(items, 10, 20)), Taken::stored);
    EXPECT_EQ(take(part(items, 30, 35)), Taken::stored);
    EXPECT_EQ(take(part(items, 65, 35)), Taken::stored);
    EXPECT_TRUE(stream->hash_ok());
}

TEST_F(JobStreamTest, GoesOnInTheMidstOfAJobAndStillVerifiesItsHash) {
    items = turns(50);
    const std::vector<Item> before(items.begin(), items.begin() + 20);
    const auto begin = [&](std::uint64_t hash_before) {
        stream->open_at(sc::job_hash(items), 50, {20, hash_before});
        EXPECT_EQ(take(part(items, 10, 15)), Taken::stored);
        EXPECT_EQ(take(part(items, 25, 25)), Taken::stored);
    };
    begin(sc::job_hash(before));
    EXPECT_TRUE(stream->hash_ok());
    EXPECT_EQ(stream->items().size(), 30U);
    EXPECT_EQ(*stream->items().front(), items[20]);
    begin(sc::job_hash(before) + 1);
    EXPECT_EQ(stream->refused().refusal, static_cast<std::uint16_t>(Refusal::job_mismatch));
}

TEST_F(JobStreamTest, WithoutItsRulesItIsWorse) {
    items = turns(10);
    JobStream back({.keeps_ahead = false});
    back.open(sc::job_hash(items), 10);
    EXPECT_EQ(back.take(part(items, 5, 5)), Taken::ahead);
    EXPECT_EQ(back.take(part(items, 0, 5)), Taken::stored);
    back.step(100);
    EXPECT_EQ(back.received(), 5U) << "what was ahead is gone";
    JobStream blind({.checks_index = false});
    blind.open(sc::job_hash(items), 10);
    for (int i = 0; i < 2; ++i) {
        EXPECT_EQ(blind.take(part(items, 0, 4)), Taken::stored);
        blind.step(100);
    }
    EXPECT_EQ(blind.items().size(), 8U) << "taken twice";
}

TEST_F(JobStreamTest, DropsBlocksOfAnotherJobAndWithoutAJob) {
    items = turns(3);
    EXPECT_EQ(take(part(items, 0, 3)), Taken::foreign);
    open(3);
    Block block = part(items, 0, 3);
    ++block.job_low;
    EXPECT_EQ(take(block), Taken::foreign);
    stream->close();
    EXPECT_EQ(take(part(items, 0, 3)), Taken::foreign);
    EXPECT_EQ(stream->received(), 0U);
}

TEST_F(JobStreamTest, RefusesAMalformedBlockWhereItGoesWrong) {
    open(10);
    Block block = part(items, 0, 5);
    block.count = 4;
    EXPECT_EQ(take(block), Taken::stored);
    EXPECT_EQ(stream->refused().refusal, static_cast<std::uint16_t>(Refusal::malformed_block));
    EXPECT_EQ(stream->refused().item, 4U);
    EXPECT_EQ(stream->received(), 4U);
    EXPECT_EQ(take(part(items, 0, 5)), Taken::refused) << "the job is refused now";
    EXPECT_EQ(stream->received(), 4U);
}

TEST_F(JobStreamTest, RefusesItemsBeyondThoseAnnounced) {
    open(10);
    const std::vector<Item> more = turns(11);
    Block block = part(more, 0, 11);
    block.job_low = stream->job_low();
    EXPECT_EQ(take(block), Taken::refused);
    EXPECT_EQ(stream->refused().refusal, static_cast<std::uint16_t>(Refusal::too_many_points));
    EXPECT_EQ(stream->refused().item, 10U);
    EXPECT_EQ(stream->received(), 0U);
}

TEST_F(JobStreamTest, RefusesIndicesAtTheEndOf32Bits) {
    open(10);
    Block block = part(items, 0, 5);
    block.first = 0xFFFFFFFF;
    EXPECT_EQ(take(block), Taken::refused);
    EXPECT_EQ(stream->refused().refusal, static_cast<std::uint16_t>(Refusal::too_many_points));
}

TEST_F(JobStreamTest, RefusesAJobWhoseHashDoesNotComeOut) {
    items = turns(4);
    stream->open(sc::job_hash(items) ^ (1ULL << 40U), 4);
    EXPECT_EQ(take(part(items, 0, 4)), Taken::stored);
    EXPECT_FALSE(stream->hash_ok());
    EXPECT_EQ(stream->refused().refusal, static_cast<std::uint16_t>(Refusal::job_mismatch));
}

TEST_F(JobStreamTest, AnEmptyJobIsVerifiedAtOnce) {
    stream->open(sc::job_hash({}), 0);
    EXPECT_TRUE(stream->hash_ok());
    stream->open(1, 0);
    EXPECT_FALSE(stream->hash_ok());
    EXPECT_EQ(stream->refused().refusal, static_cast<std::uint16_t>(Refusal::job_mismatch));
}

TEST_F(JobStreamTest, TheSameJobKeepsWhatHasArrivedAndAnotherDoesNot) {
    open(10);
    EXPECT_EQ(take(part(items, 0, 6)), Taken::stored);
    stream->open(sc::job_hash(items), 10);
    EXPECT_EQ(stream->received(), 6U);
    EXPECT_EQ(stream->items().size(), 6U);
    stream->open(sc::job_hash(items), 11);
    EXPECT_EQ(stream->received(), 0U);
    EXPECT_TRUE(stream->items().empty());
}

TEST_F(JobStreamTest, AClosedOrRefusedJobBeginsAnew) {
    open(10);
    EXPECT_EQ(take(part(items, 0, 6)), Taken::stored);
    stream->close();
    EXPECT_TRUE(stream->items().empty());
    EXPECT_EQ(stream->received(), 6U) << "how far it came stays readable";
    stream->open(sc::job_hash(items), 10);
    EXPECT_EQ(stream->received(), 0U);
    EXPECT_EQ(take(part(items, 0, 6)), Taken::stored);
    stream->refuse(3, Refusal::out_of_travel, 1, -5);
    stream->refuse(4, Refusal::in_keep_out, 2, 5);
    EXPECT_EQ(stream->refused().item, 3U) << "the first refusal counts";
    stream->open(sc::job_hash(items), 10);
    EXPECT_EQ(stream->refused().refusal, 0U);
    EXPECT_EQ(stream->received(), 0U);
    EXPECT_EQ(take(part(items, 0, 10)), Taken::stored);
    EXPECT_TRUE(stream->hash_ok());
}

}  // namespace
