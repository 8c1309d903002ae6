// SPDX-License-Identifier: Apache-2.0
#include "firmware/link/endpoint.hpp"

#include <memory>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "link_host.hpp"
#include "shared/link/blocks.hpp"
#include "shared/path/job_hash.hpp"

namespace {

using namespace sc::link;  // NOLINT(google-build-using-namespace): the subject of this file
using sc::Item;
using sc::Refusal;
using Kind = LinkEvent::Kind;

constexpr std::uint16_t code(Refusal refusal) { return static_cast<std::uint16_t>(refusal); }

class EndpointTest : public testing::Test {
protected:
    void connect(std::uint32_t session = 7) {
        host.send(endpoint, tick, hello_of(session));
        EXPECT_EQ(next().kind, Kind::session_open);
        host.collect(endpoint);
        host.clear();
    }
    LinkEvent next() {
        LinkEvent event;
        endpoint.poll(event);
        return event;
    }
    void open_job(std::size_t count) {
        items.clear();
        for (std::size_t i = 0; i < count; ++i) {
            items.emplace_back(sc::Turn{static_cast<std::int32_t>(i)});
        }
        job = sc::job_hash(items);
        endpoint.open_job(job, static_cast<std::uint32_t>(count));
        host.collect(endpoint);
        host.clear();
    }
    void advance(std::int64_t ticks, std::size_t room = 1024) {
        for (std::int64_t i = 0; i < ticks; ++i) {
            endpoint.receive(++tick, {});
            host.collect(endpoint, room);
        }
    }

    std::unique_ptr<Endpoint> owned = std::make_unique<Endpoint>(sc::reference_machine(), 99);
    Endpoint& endpoint = *owned;
    LinkHost host;
    std::int64_t tick = 1000;
    std::vector<Item> items;
    std::uint64_t job = 0;
};

// --- session ------------------------------------------------------------------------------------------------------

TEST_F(EndpointTest, HelloOpensASession) {
    EXPECT_FALSE(endpoint.session_open());
    EXPECT_FALSE(endpoint.alive(tick));
    host.send(endpoint, tick, hello_of(7));
    EXPECT_EQ(next().kind, Kind::session_open);
    EXPECT_EQ(next().kind, Kind::none);
    EXPECT_TRUE(endpoint.session_open());
    host.collect(endpoint);
    ASSERT_EQ(host.hellos.size(), 1U);
    EXPECT_EQ(host.hellos[0].refusal, 0U);
    EXPECT_EQ(host.hellos[0].schema, kSchemaHash);
    EXPECT_EQ(host.hellos[0].session, 7U);
    EXPECT_EQ(host.hellos[0].boot, 99U);
    EXPECT_EQ(host.hellos[0].config_bytes, kConfigSize);
}

TEST_F(EndpointTest, HelloIsRefusedWithItsReason) {
    Hello schema = hello_of(7);
    ++schema.schema;
    Hello version = hello_of(7);
    ++version.major;
    ++version.schema;
    const std::vector<std::pair<Hello, Refusal>> cases{{schema, Refusal::schema_mismatch},
                                                       {version, Refusal::version_mismatch},
                                                       {hello_of(7, 19), Refusal::bad_config},
                                                       {hello_of(7, 501), Refusal::bad_config}};
    for (const auto& [hello, refusal] : cases) {
        host.clear();
        host.send(endpoint, tick, hello);
        host.collect(endpoint);
        ASSERT_EQ(host.hellos.size(), 1U);
        EXPECT_EQ(host.hellos[0].refusal, code(refusal));
        EXPECT_FALSE(endpoint.session_open());
        EXPECT_EQ(next().kind, Kind::none);
    }
    EXPECT_EQ(endpoint.counters().hellos_refused, cases.size());
}

TEST_F(EndpointTest, AHostOfTheOlderMinorVersionIsUnderstoodAndSpokenToInItsWords) {
    Hello hello = hello_of(7);
    hello.schema = kSchemaHashes[0];
    hello.minor = 0;
    host.send(endpoint, tick, hello);
    EXPECT_EQ(next().kind, Kind::session_open);
    host.set_minor(0);
    host.collect(endpoint);
    ASSERT_EQ(host.hellos.size(), 1U);
    EXPECT_EQ(host.hellos[0].refusal, 0U);
    EXPECT_EQ(host.hellos[0].schema, kSchemaHashes[0]);
    EXPECT_EQ(host.hellos[0].minor, 0U);
    EXPECT_EQ(endpoint.minor(), 0U);
    host.send(endpoint, tick, Command{1, static_cast<std::uint8_t>(Verb::home), 0, 0, 0});
    EXPECT_EQ(next().kind, Kind::command);
    open_job(100);
    host.send(endpoint, tick, make_block(job, items, 10));
    host.collect(endpoint);
    EXPECT_EQ(host.acks.size(), 1U);
    EXPECT_TRUE(host.missing.empty()) << "it would not know what that is";
    EXPECT_EQ(host.frames_bad(), 0U);
}

TEST_F(EndpointTest, AGapIsToldWithTheNewestMessageHeard) {
    connect();
    open_job(200);
    host.send(endpoint, tick, make_block(job, std::span(items).first(40), 20));
    host.collect(endpoint);
    ASSERT_EQ(host.missing.size(), 1U);
    EXPECT_EQ(host.missing[0].count, 1U);
    EXPECT_EQ(host.missing[0].from[0], 0U);
    EXPECT_EQ(host.missing[0].until[0], 20U);
    const std::uint16_t heard = host.missing[0].heard;
    host.clear();
    host.send(endpoint, tick, Heartbeat{1});
    host.collect(endpoint);
    EXPECT_TRUE(host.missing.empty()) << "told once for each block";
    host.send(endpoint, tick, make_block(job, std::span(items).first(60), 50));
    host.collect(endpoint);
    ASSERT_EQ(host.missing.size(), 1U);
    EXPECT_EQ(host.missing[0].count, 2U);
    EXPECT_EQ(host.missing[0].heard, heard + 2);
}

TEST_F(EndpointTest, AJobBegunInItsMidstIsAcknowledgedFromThere) {
    connect();
    open_job(50);
    const std::uint64_t before = sc::job_hash(std::span(items).first(20));
    endpoint.resume_job({.job = job, .items = 50, .first = 20, .hash_before = before});
    host.send(endpoint, tick, make_block(job, items, 20));
    advance(30);
    EXPECT_EQ(host.acks.back().received, 50U);
    EXPECT_EQ(host.acks.back().fired, 20U);
    EXPECT_TRUE(endpoint.job_hash_ok());
}

TEST_F(EndpointTest, AQuestionForThePositionIsAnsweredWithItsToken) {
    connect();
    host.send(endpoint, tick, PositionRequest{17});
    const LinkEvent event = next();
    ASSERT_EQ(event.kind, Kind::position_request);
    Position position;
    position.token = event.position_request.token;
    position.pulses = 812;
    endpoint.position(position);
    host.collect(endpoint);
    ASSERT_EQ(host.positions.size(), 1U);
    EXPECT_EQ(host.positions[0].token, 17U);
    EXPECT_EQ(host.positions[0].pulses, 812U);
}

TEST_F(EndpointTest, TheShortestAndLongestTimeoutsAreTaken) {
    for (const std::uint16_t timeout : {std::uint16_t{20}, std::uint16_t{500}}) {
        host.send(endpoint, tick, hello_of(7, timeout));
        EXPECT_TRUE(endpoint.alive(tick + timeout));
        EXPECT_FALSE(endpoint.alive(tick + timeout + 1));
    }
}

TEST_F(EndpointTest, AnythingValidKeepsTheSessionAlive) {
    connect();
    tick += 100;
    EXPECT_TRUE(endpoint.alive(tick));
    host.send(endpoint, tick, Heartbeat{1});
    EXPECT_EQ(endpoint.last_heard(), tick);
    EXPECT_TRUE(endpoint.alive(tick + 100));
    EXPECT_FALSE(endpoint.alive(tick + 101));
    endpoint.receive(tick + 101, std::vector<std::uint8_t>{1, 2, 3, 0});
    EXPECT_FALSE(endpoint.alive(tick + 101)) << "garbage is no sign of life";
}

TEST_F(EndpointTest, ARepeatedMessageIsNoSignOfLife) {
    connect();
    const auto beat = host.framed(Heartbeat{1});
    endpoint.receive(tick + 50, beat);
    endpoint.receive(tick + 120, beat);
    EXPECT_EQ(endpoint.last_heard(), tick + 50);
    EXPECT_EQ(endpoint.counters().messages_repeated, 1U);
}

TEST_F(EndpointTest, TheSameSessionResumesAndKeepsItsJob) {
    connect();
    open_job(5);
    host.send(endpoint, tick, make_block(job, items, 0));
    tick += 5000;
    EXPECT_FALSE(endpoint.alive(tick));
    host.set_counter(0);
    host.send(endpoint, tick, hello_of(7));
    EXPECT_EQ(next().kind, Kind::session_resumed);
    EXPECT_TRUE(endpoint.alive(tick));
    EXPECT_EQ(endpoint.received(), 5U);
    host.send(endpoint, tick, Command{50, 1, 0, 0, 0});
    EXPECT_EQ(next().kind, Kind::command) << "the restarted counter is taken";
}

TEST_F(EndpointTest, AnotherSessionIsRefusedWhileOneIsAlive) {
    connect(7);
    LinkHost other;
    other.send(endpoint, tick + 100, hello_of(8));
    other.collect(endpoint);
    ASSERT_EQ(other.hellos.size(), 1U);
    EXPECT_EQ(other.hellos[0].refusal, code(Refusal::wrong_state));
    EXPECT_EQ(next().kind, Kind::none);
    EXPECT_FALSE(endpoint.alive(tick + 101)) << "the refused hello is no sign of life";
    host.send(endpoint, tick + 101, Command{1, 1, 0, 0, 0});
    EXPECT_EQ(next().kind, Kind::command) << "the session goes on as it was";
}

TEST_F(EndpointTest, AnotherSessionTakesOverASilentOne) {
    connect(7);
    host.send(endpoint, tick, Command{1, 1, 0, 0, 0});
    host.send(endpoint, tick + 101, hello_of(8));
    EXPECT_EQ(next().kind, Kind::session_open) << "requests of the old session are forgotten";
    EXPECT_EQ(next().kind, Kind::none);
    host.send(endpoint, tick + 101, Command{1, 1, 0, 0, 0});
    EXPECT_EQ(next().kind, Kind::command) << "sequences begin anew";
}

TEST_F(EndpointTest, OnlyRequestsAreAnsweredBeforeASession) {
    host.send(endpoint, tick, Heartbeat{1});
    host.send(endpoint, tick, ConfigRequest{0});
    host.send(endpoint, tick, Block{});
    endpoint.status({});
    EXPECT_EQ(host.collect(endpoint), 0U);
    host.send(endpoint, tick, Command{4, 1, 0, 0, 0});
    host.collect(endpoint);
    ASSERT_EQ(host.replies.size(), 1U);
    EXPECT_EQ(host.replies[0].sequence, 4U);
    EXPECT_EQ(host.replies[0].refusal, code(Refusal::not_connected));
    EXPECT_EQ(next().kind, Kind::none);
}

// --- requests -----------------------------------------------------------------------------------------------------

TEST_F(EndpointTest, RequestsBecomeEventsInOrder) {
    connect();
    host.send(endpoint, tick, Command{1, 11, 2, -3, 4});
    host.send(endpoint, tick, JobOpen{2, 0x1122334455667788ULL, 9});
    SetCompensation compensation;
    compensation.sequence = 3;
    compensation.axis_matrix[8] = 1.25;
    host.send(endpoint, tick, compensation);
    LinkEvent event = next();
    EXPECT_EQ(event.kind, Kind::command);
    EXPECT_EQ(event.command.verb, 11U);
    EXPECT_EQ(event.command.arg1, -3);
    event = next();
    EXPECT_EQ(event.kind, Kind::job_open);
    EXPECT_EQ(event.job_open.job, 0x1122334455667788ULL);
    EXPECT_EQ(event.job_open.items, 9U);
    event = next();
    EXPECT_EQ(event.kind, Kind::compensation);
    EXPECT_EQ(event.compensation.axis_matrix[8], 1.25);
}

TEST_F(EndpointTest, ARepeatedRequestIsAnsweredAgainAndNotDoneAgain) {
    connect();
    const Command command{5, 1, 0, 0, 0};
    host.send(endpoint, tick, command);
    EXPECT_EQ(next().kind, Kind::command);
    host.send(endpoint, tick, command);
    EXPECT_EQ(next().kind, Kind::none) << "its answer is not known yet";
    endpoint.reply(5, Refusal::not_homed, 3);
    host.collect(endpoint);
    host.send(endpoint, tick, command);
    EXPECT_EQ(next().kind, Kind::none);
    host.collect(endpoint);
    ASSERT_EQ(host.replies.size(), 2U);
    for (const CommandReply& reply : host.replies) {
        EXPECT_EQ(reply.sequence, 5U);
        EXPECT_EQ(reply.refusal, code(Refusal::not_homed));
        EXPECT_EQ(reply.detail, 3);
    }
    EXPECT_EQ(host.collect(endpoint), 0U) << "an answer is sent once";
}

TEST_F(EndpointTest, AnOvertakenRequestIsRefusedAndNotDone) {
    connect();
    host.send(endpoint, tick, Command{6, 8, 0, 0, 0});
    EXPECT_EQ(next().kind, Kind::command);
    host.send(endpoint, tick, Command{5, 6, 0, 0, 0});
    EXPECT_EQ(next().kind, Kind::none);
    host.collect(endpoint);
    ASSERT_EQ(host.replies.size(), 1U);
    EXPECT_EQ(host.replies[0].sequence, 5U);
    EXPECT_EQ(host.replies[0].refusal, code(Refusal::wrong_state));
}

TEST_F(EndpointTest, RequestsBeyondTheRoomAreDroppedAndMayComeAgain) {
    connect();
    for (std::uint32_t sequence = 1; sequence <= 10; ++sequence) {
        host.send(endpoint, tick, Command{sequence, 1, 0, 0, 0});
    }
    EXPECT_EQ(endpoint.counters().events_lost, 2U);
    for (std::uint32_t sequence = 1; sequence <= 8; ++sequence) {
        const LinkEvent event = next();
        EXPECT_EQ(event.command.sequence, sequence);
        endpoint.reply(sequence, Refusal::none, 0);
    }
    EXPECT_EQ(next().kind, Kind::none);
    host.send(endpoint, tick, Command{9, 1, 0, 0, 0});
    EXPECT_EQ(next().command.sequence, 9U);
}

TEST_F(EndpointTest, TheHelloReplyNamesTheNewestSequence) {
    connect();
    host.send(endpoint, tick, Command{41, 1, 0, 0, 0});
    host.send(endpoint, tick, hello_of(7));
    host.collect(endpoint);
    ASSERT_EQ(host.hellos.size(), 1U);
    EXPECT_EQ(host.hellos[0].last_sequence, 41U);
}

TEST_F(EndpointTest, CountsLostAndSpoiltMessages) {
    connect();
    static_cast<void>(host.framed(Heartbeat{1}));
    static_cast<void>(host.framed(Heartbeat{2}));
    host.send(endpoint, tick, Heartbeat{3});
    auto spoilt = host.framed(Heartbeat{4});
    spoilt[5] ^= 0x10U;
    endpoint.receive(tick, spoilt);
    host.send(endpoint, tick, Status{});
    endpoint.status({});
    host.collect(endpoint);
    ASSERT_EQ(host.statuses.size(), 1U);
    EXPECT_EQ(host.statuses[0].messages_lost, 3U);
    EXPECT_EQ(host.statuses[0].frames_bad, 2U) << "a wrong checksum, and a message of the other direction";
}

// --- configuration ------------------------------------------------------------------------------------------------

TEST_F(EndpointTest, TheConfigurationIsReadInChunksOfAnySize) {
    for (const std::size_t room : {std::size_t{40}, std::size_t{100}, std::size_t{1024}}) {
        host.send(endpoint, tick, hello_of(7));
        host.collect(endpoint);
        std::vector<std::uint8_t> config;
        while (config.size() < kConfigSize) {
            host.clear();
            host.send(endpoint, tick, ConfigRequest{static_cast<std::uint16_t>(config.size())});
            host.collect(endpoint, room);
            ASSERT_EQ(host.chunks.size(), 1U);
            const ConfigChunk& chunk = host.chunks[0];
            ASSERT_EQ(chunk.offset, config.size());
            ASSERT_GT(chunk.data.size, 0U);
            config.insert(config.end(), chunk.data.data.begin(), chunk.data.data.begin() + chunk.data.size);
        }
        const auto machine = deserialise(config);
        ASSERT_TRUE(machine.has_value());
        EXPECT_EQ(machine->axis[0].travel_min, sc::reference_machine().axis[0].travel_min);
    }
}

TEST_F(EndpointTest, AConfigurationRequestAtOrPastTheEndGetsAnEmptyChunk) {
    connect();
    for (const std::size_t offset : {kConfigSize, std::size_t{0xFFFF}}) {
        host.clear();
        host.send(endpoint, tick, ConfigRequest{static_cast<std::uint16_t>(offset)});
        host.collect(endpoint);
        ASSERT_EQ(host.chunks.size(), 1U);
        EXPECT_EQ(host.chunks[0].data.size, 0U);
    }
}

// --- stream -------------------------------------------------------------------------------------------------------

TEST_F(EndpointTest, EveryBlockIsAcknowledged) {
    connect();
    open_job(100);
    host.send(endpoint, tick, make_block(job, items, 0));
    host.collect(endpoint);
    ASSERT_EQ(host.acks.size(), 1U);
    advance(50);  // until the block is read
    const std::uint32_t received = host.acks.back().received;
    EXPECT_EQ(received, endpoint.received());
    EXPECT_GT(received, 20U);
    host.acks.erase(host.acks.begin(), host.acks.end() - 1);
    EXPECT_EQ(host.acks[0].job_low, static_cast<std::uint32_t>(job & 0xFFFFFFFFU));
    EXPECT_EQ(host.acks[0].free_items, (JobStream::kKept - 1) * ((3 * 16 + received) / 4)) << "as many blocks like it";
    host.send(endpoint, tick, make_block(job, items, received + 1));
    host.collect(endpoint);
    ASSERT_EQ(host.acks.size(), 2U) << "a gap is acknowledged with the item wanted";
    EXPECT_EQ(host.acks[1].received, received);
    host.send(endpoint, tick, make_block(job, items, 0));
    host.collect(endpoint);
    ASSERT_EQ(host.acks.size(), 3U) << "so is a repetition";
    EXPECT_EQ(host.acks[2].received, received);
    EXPECT_EQ(endpoint.counters().items_repeated, received);
}

TEST_F(EndpointTest, ProgressIsToldAtMostEveryFiveTicks) {
    connect();
    open_job(100);
    std::vector<std::int64_t> told;
    for (int i = 1; i <= 30; ++i) {
        endpoint.receive(++tick, {});
        endpoint.progress(static_cast<std::uint32_t>(i), 0, {});
        host.clear();
        host.collect(endpoint);
        if (!host.acks.empty()) {
            told.push_back(tick);
            EXPECT_EQ(host.acks[0].planned, static_cast<std::uint32_t>(i));
        }
    }
    ASSERT_GE(told.size(), 5U);
    for (std::size_t i = 1; i < told.size(); ++i) {
        EXPECT_EQ(told[i] - told[i - 1], Endpoint::kAckEveryTicks);
    }
}

TEST_F(EndpointTest, TheFiredPositionAndTheWindowGoOutToo) {
    connect();
    open_job(100);
    host.send(endpoint, tick, make_block(job, items, 0));
    advance(1);
    host.clear();
    endpoint.progress(20, 10, {.path = 3, .pass = 1, .item = 10, .pulses = 1234});
    endpoint.items().pop();
    advance(Endpoint::kAckEveryTicks);
    ASSERT_EQ(host.acks.size(), 1U);
    EXPECT_EQ(host.acks[0].planned, 20U);
    EXPECT_EQ(host.acks[0].fired, 10U);
    EXPECT_EQ(host.acks[0].path, 3U);
    EXPECT_EQ(host.acks[0].pass, 1U);
    EXPECT_EQ(host.acks[0].pulses, 1234U);
    host.clear();
    endpoint.items().pop();
    advance(Endpoint::kAckEveryTicks);
    EXPECT_EQ(host.acks.size(), 1U) << "room alone is worth telling";
}

TEST_F(EndpointTest, ALostAcknowledgementIsMadeGood) {
    connect();
    open_job(100);
    host.send(endpoint, tick, make_block(job, items, 0));
    for (int i = 0; i < 50; ++i) {
        endpoint.receive(++tick, {});  // the block is read, and nothing sent
    }
    std::vector<std::uint8_t> lost(1024);
    EXPECT_GT(endpoint.transmit(lost), 0U);
    advance(Endpoint::kAckRepeatTicks);
    ASSERT_EQ(host.acks.size(), 1U);
    EXPECT_EQ(host.acks[0].received, endpoint.received());
}

TEST_F(EndpointTest, TheLastAcknowledgementOutlivesTheJob) {
    connect();
    open_job(3);
    host.send(endpoint, tick, make_block(job, items, 0));
    endpoint.progress(3, 3, {});
    EXPECT_TRUE(endpoint.job_hash_ok());
    endpoint.close_job();
    advance(2 * Endpoint::kAckRepeatTicks);
    ASSERT_GE(host.acks.size(), 2U);
    EXPECT_EQ(host.acks.back().fired, 3U);
    EXPECT_EQ(host.acks.back().received, 3U);
    EXPECT_EQ(host.acks.back().free_items, 0U);
}

TEST_F(EndpointTest, ANewJobBeginsWithoutProgressAndTheSameKeepsIt) {
    connect();
    open_job(3);
    host.send(endpoint, tick, make_block(job, items, 0));
    endpoint.progress(2, 1, {});
    endpoint.open_job(job, 3);
    host.clear();
    host.collect(endpoint);
    ASSERT_EQ(host.acks.size(), 1U);
    EXPECT_EQ(host.acks[0].planned, 2U);
    endpoint.open_job(job + 1, 3);
    host.clear();
    host.collect(endpoint);
    ASSERT_EQ(host.acks.size(), 1U);
    EXPECT_EQ(host.acks[0].planned, 0U);
    EXPECT_EQ(host.acks[0].received, 0U);
}

TEST_F(EndpointTest, ARefusalIsRepeatedUntilTheJobIsClosed) {
    connect();
    open_job(3);
    endpoint.refuse_item(2, Refusal::out_of_travel, 1, -40'000'001);
    EXPECT_EQ(endpoint.job_refusal(), Refusal::out_of_travel);
    host.collect(endpoint);
    advance(2 * Endpoint::kRefusedRepeatTicks);
    ASSERT_EQ(host.refused.size(), 3U);
    for (const JobRefused& refused : host.refused) {
        EXPECT_EQ(refused.item, 2U);
        EXPECT_EQ(refused.refusal, code(Refusal::out_of_travel));
        EXPECT_EQ(refused.axis, 1U);
        EXPECT_EQ(refused.value, -40'000'001);
    }
    endpoint.close_job();
    host.clear();
    advance(2 * Endpoint::kRefusedRepeatTicks);
    EXPECT_TRUE(host.refused.empty());
    EXPECT_EQ(endpoint.job_refusal(), Refusal::none);
}

TEST_F(EndpointTest, TheEndpointRefusesByItself) {
    connect();
    open_job(3);
    Block block = make_block(job, items, 0);
    block.count = 2;
    host.send(endpoint, tick, block);
    host.collect(endpoint);
    ASSERT_EQ(host.refused.size(), 1U);
    EXPECT_EQ(host.refused[0].refusal, code(Refusal::malformed_block));
    EXPECT_EQ(endpoint.job_refusal(), Refusal::malformed_block);
    EXPECT_EQ(endpoint.received(), 2U) << "up to where it goes wrong";
}

// --- sending ------------------------------------------------------------------------------------------------------

TEST_F(EndpointTest, SendsTheMostUrgentFirst) {
    connect();
    open_job(3);
    host.send(endpoint, tick, ConfigRequest{0});
    endpoint.status({});
    host.send(endpoint, tick, make_block(job, items, 0));
    endpoint.refuse_item(0, Refusal::bad_speed, 0, 0);
    host.send(endpoint, tick, Command{1, 1, 0, 0, 0});
    endpoint.reply(1, Refusal::none, 0);
    host.send(endpoint, tick, hello_of(7));
    host.collect(endpoint);
    advance(1);  // a status waits for a tick without an acknowledgement
    const std::vector<std::uint8_t> expected{HelloReply::kId, CommandReply::kId, JobRefused::kId,
                                             StreamAck::kId,  ConfigChunk::kId,  Status::kId};
    EXPECT_EQ(host.order, expected);
}

TEST_F(EndpointTest, WhatDoesNotFitStaysDueAndCountersHaveNoGap) {
    connect();
    open_job(3);
    host.send(endpoint, tick, ConfigRequest{0});
    endpoint.status({});
    host.send(endpoint, tick, make_block(job, items, 0));
    host.send(endpoint, tick, Command{1, 1, 0, 0, 0});
    endpoint.reply(1, Refusal::none, 0);
    std::size_t sent = 0;
    for (std::size_t i = 0; i < 8; ++i) {
        endpoint.receive(++tick, {});
        const std::size_t size = host.collect(endpoint, 75);
        EXPECT_LE(size, 75U);
        sent += size > 0 ? 1 : 0;
    }
    EXPECT_GE(sent, 3U);
    EXPECT_EQ(host.replies.size(), 1U);
    EXPECT_GE(host.acks.size(), 1U);
    EXPECT_EQ(host.statuses.size(), 1U);
    EXPECT_EQ(host.chunks.size(), 1U);
    for (std::size_t i = 1; i < host.counters.size(); ++i) {
        EXPECT_EQ(host.counters[i], host.counters[i - 1] + 1);
    }
    EXPECT_EQ(host.frames_bad(), 0U);
}

TEST_F(EndpointTest, SendsNothingIntoNoRoom) {
    connect();
    endpoint.status({});
    EXPECT_EQ(endpoint.transmit({}), 0U);
    host.collect(endpoint);
    EXPECT_EQ(host.statuses.size(), 1U);
}

TEST_F(EndpointTest, ANewStatusReplacesTheOld) {
    connect();
    Status status;
    status.state = 3;
    endpoint.status(status);
    status.state = 4;
    endpoint.status(status);
    host.collect(endpoint);
    ASSERT_EQ(host.statuses.size(), 1U);
    EXPECT_EQ(host.statuses[0].state, 4U);
    EXPECT_EQ(host.collect(endpoint), 0U);
}

}  // namespace
