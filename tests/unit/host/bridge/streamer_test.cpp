// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/streamer.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "shared/path/job_hash.hpp"
#include "tests/unit/host/bridge/fake_cell.hpp"

namespace sc::host {
namespace {

using test::example_items;
using test::FakeCell;
using test::Trouble;

/// A connected client with its job opened and started.
struct Started {
    explicit Started(FakeCell& cell, const std::vector<Item>& items) : client(cell, {}) {
        client.connect();
        client.open_job(job_hash(items), static_cast<std::uint32_t>(items.size()));
        client.command(link::Verb::start);
    }
    CellClient client;
};

StreamJob job_of(const std::vector<Item>& items) { return {job_hash(items), items, 0.0}; }

TEST(Streamer, EachItemIsTakenOnceInOrder) {
    const std::vector<Item> items = example_items(10, 30);
    FakeCell cell;
    Started started(cell, items);
    Streamer streamer(started.client, job_of(items), {}, nullptr);
    streamer.run();
    EXPECT_EQ(cell.taken, items);
    EXPECT_EQ(cell.repeated, 0U);
    EXPECT_EQ(streamer.progress().sent, items.size());
    EXPECT_EQ(streamer.progress().fired, items.size());
}

TEST(Streamer, EachItemIsTakenOnceOverABadLink) {
    const std::vector<Item> items = example_items(20, 40);
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        FakeCell cell({.drop = 0.1, .repeat = 0.1, .corrupt = 0.05, .seed = seed});
        Started started(cell, items);
        Streamer streamer(started.client, job_of(items), {}, nullptr);
        streamer.run();
        EXPECT_EQ(cell.taken, items) << "seed " << seed;
    }
}

/// A job whose start comes with an acknowledgement that a carrier has held back since an earlier start of the cell.
void stream_past_a_stale_ack(FakeCell& cell) {
    const std::vector<Item> items = example_items(10, 30);
    cell.each_period = [&cell] {
        if (cell.now() > HostTime{} + std::chrono::seconds(60)) {
            throw std::runtime_error("the stream has stalled at item " + std::to_string(cell.taken.size()));
        }
    };
    Started started(cell, items);
    Streamer streamer(started.client, job_of(items), {.items_per_block = 10}, nullptr);
    streamer.run();
    EXPECT_EQ(cell.taken, items);
}

TEST(Streamer, AStaleAckOfMoreThanHasBeenSentMisleadsNobody) {
    for (const std::uint8_t minor : {std::uint8_t{0}, std::uint8_t{1}, link::kProtocolMinor}) {
        FakeCell cell;
        cell.minor = minor;
        cell.schema = link::kSchemaHashes[minor];
        cell.stale_ack = {.received = 250, .planned = 240, .fired = 240, .free_items = 64};
        stream_past_a_stale_ack(cell);
    }
}

TEST(Streamer, AStaleAckOfItemsThatWereLostIsForgotten) {
    for (const std::uint8_t minor : {std::uint8_t{0}, std::uint8_t{1}, link::kProtocolMinor}) {
        FakeCell cell;
        cell.minor = minor;
        cell.schema = link::kSchemaHashes[minor];
        cell.blocks_lost = 1;
        cell.stale_ack = {.received = 10, .free_items = 64};
        stream_past_a_stale_ack(cell);
    }
}

TEST(Streamer, SetsTheOverrideThatIsWantedOnceAndStreamsOn) {
    const std::vector<Item> items = example_items(10, 30);
    FakeCell cell;
    Started started(cell, items);
    StreamOptions options;
    options.wanted_override = [&](std::uint8_t percent) -> std::optional<std::uint8_t> {
        EXPECT_TRUE(percent == 100 || percent == 60);
        return cell.fired > items.size() / 2 ? std::optional<std::uint8_t>(60) : std::nullopt;
    };
    Streamer streamer(started.client, job_of(items), options, nullptr);
    streamer.run();
    EXPECT_EQ(cell.override_percent, 60);
    EXPECT_EQ(cell.done[link::Verb::set_override], 1);
    EXPECT_EQ(cell.taken, items);
}

TEST(Streamer, AnyBlockSizeGivesTheSameItems) {
    const std::vector<Item> items = example_items(3, 50);
    for (const std::uint32_t size : {1U, 2U, 7U, 64U, 255U, 100000U}) {
        FakeCell cell;
        Started started(cell, items);
        Streamer streamer(started.client, job_of(items), {.items_per_block = size}, nullptr);
        streamer.run();
        EXPECT_EQ(cell.taken, items) << size;
        EXPECT_LE(*std::max_element(cell.block_sizes.begin(), cell.block_sizes.end()), size);
    }
}

TEST(Streamer, NeverSendsBeyondTheWindow) {
    const std::vector<Item> items = example_items(10, 40);
    FakeCell cell;
    cell.capacity = 24;
    cell.items_per_period = 3;
    Started started(cell, items);
    Streamer streamer(started.client, job_of(items), {}, nullptr);
    streamer.run();
    // The fake cell drops what does not fit: without a loss nothing would ever have to be sent again.
    EXPECT_EQ(cell.taken, items);
    EXPECT_EQ(cell.repeated, 0U);
    EXPECT_EQ(started.client.repeats(), 0U);
}

TEST(Streamer, ResumesAStarvedJob) {
    const std::vector<Item> items = example_items(10, 30);
    FakeCell cell;
    cell.starve_at_item = 100;
    Started started(cell, items);
    Streamer streamer(started.client, job_of(items), {}, nullptr);
    streamer.run();
    EXPECT_EQ(cell.done[link::Verb::resume], 1);
    EXPECT_EQ(cell.taken, items);
}

TEST(Streamer, ReconnectsAndResumesAfterALinkHold) {
    const std::vector<Item> items = example_items(10, 30);
    FakeCell cell;
    cell.hold_link_at_item = 100;
    Started started(cell, items);
    Streamer streamer(started.client, job_of(items), {}, nullptr);
    streamer.run();
    EXPECT_GE(cell.hellos, 1);
    EXPECT_GE(cell.done[link::Verb::resume], 1);
    EXPECT_EQ(cell.jobs_opened, 1);
    EXPECT_EQ(cell.taken, items);
}

TEST(Streamer, ReportsARefusedItemByNumber) {
    const std::vector<Item> items = example_items(10, 30);
    FakeCell cell;
    cell.refuse_item = 77;
    Started started(cell, items);
    Streamer streamer(started.client, job_of(items), {}, nullptr);
    try {
        streamer.run();
        FAIL() << "not refused";
    } catch (const CellRefused& refused) {
        EXPECT_EQ(refused.refusal, Refusal::out_of_travel);
        EXPECT_EQ(refused.detail, 77);
    }
}

TEST(Streamer, ReportsAFaultWithItsNumber) {
    const std::vector<Item> items = example_items(10, 30);
    FakeCell cell;
    cell.fault_at_item = 50;
    Started started(cell, items);
    Streamer streamer(started.client, job_of(items), {}, nullptr);
    try {
        streamer.run();
        FAIL() << "no fault";
    } catch (const CellFault& fault) {
        EXPECT_EQ(fault.fault, Fault::following_error);
    }
    streamer.hear_out();
    EXPECT_GE(streamer.progress().fired, 50U);
    EXPECT_LT(streamer.progress().fired, items.size());
}

TEST(Streamer, NoticesThatTheJobWasDropped) {
    const std::vector<Item> items = example_items(10, 30);
    FakeCell cell;
    cell.each_period = [&] {
        if (cell.fired > 60 && cell.state == State::running) {
            cell.state = State::idle;
        }
    };
    Started started(cell, items);
    Streamer streamer(started.client, job_of(items), {}, nullptr);
    EXPECT_THROW(streamer.run(), CellError);
}

TEST(Streamer, ProgressRisesToOneAndTimeLeftFallsToZero) {
    const std::vector<Item> items = example_items(10, 30);
    FakeCell cell;
    Started started(cell, items);
    Streamer streamer(started.client, {job_hash(items), items, 5.0}, {}, nullptr);
    std::vector<Progress> seen;
    streamer.on_progress([&](const Progress& progress) { seen.push_back(progress); });
    streamer.run();
    ASSERT_GT(seen.size(), 3U);
    for (std::size_t i = 1; i < seen.size(); ++i) {
        EXPECT_GE(seen[i].fraction, seen[i - 1].fraction);
        EXPECT_GE(seen[i].elapsed, seen[i - 1].elapsed);
    }
    EXPECT_EQ(seen.back().fraction, 1.0);
    EXPECT_EQ(seen.back().left, Nanoseconds(0));
    EXPECT_EQ(seen.back().items, items.size());
}

}  // namespace
}  // namespace sc::host
