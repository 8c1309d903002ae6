// SPDX-License-Identifier: Apache-2.0
// Sealed sessions at the controller's end: what must not come through, does not.
#include <array>
#include <memory>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/link/endpoint.hpp"
#include "seal_host.hpp"
#include "shared/link/blocks.hpp"
#include "shared/path/job_hash.hpp"

namespace {

using namespace sc::link;  // NOLINT(google-build-using-namespace): the subject of this file
using sc::Refusal;
namespace crypto = sc::crypto;
using Bytes = std::vector<std::uint8_t>;

constexpr std::uint16_t code(Refusal refusal) { return static_cast<std::uint16_t>(refusal); }

std::unique_ptr<Endpoint> sealed_endpoint(std::uint32_t boot = 1, std::uint8_t entropy = 0x77) {
    auto endpoint = std::make_unique<Endpoint>(sc::reference_machine(), boot);
    SealSecret secret{kTestKey, {}};
    secret.entropy.fill(entropy);
    endpoint->fit_key(secret);
    return endpoint;
}

/// With its checksum.
Bytes framed_again(Bytes plain) {
    const std::uint32_t crc = codec_detail::message_crc(plain, kProtocolMinor);
    for (unsigned i = 0; i < 4; ++i) {
        plain.push_back(static_cast<std::uint8_t>((crc >> (8U * i)) & 0xFFU));
    }
    Bytes out(kSerialCapacity);
    out.resize(cobs_encode(plain, out));
    return out;
}

/// The frame with a bit changed, and its checksum right again.
Bytes flipped(const Bytes& frame, std::size_t bit) {
    sc::link::CobsDecoder<kMessageCapacity> decoder;
    std::span<const std::uint8_t> rest(frame);
    const auto message = decoder.take(rest);
    Bytes plain(message->begin(), message->end() - 4);
    plain[bit / 8] = static_cast<std::uint8_t>(plain[bit / 8] ^ (1U << (bit % 8)));
    return framed_again(plain);
}

class Seal : public testing::Test {
protected:
    std::unique_ptr<Endpoint> owned = sealed_endpoint();
    Endpoint& endpoint = *owned;
    SealHost host{endpoint};
};

// The usual failure in the field: freshness that is out of step after a reset or a bus that was off.
TEST_F(Seal, AfterASilenceNothingCountsUntilANewChallengeAndThenAllDoes) {
    ASSERT_TRUE(host.connect());
    ASSERT_TRUE(host.done(host.sealed(host.command())));
    const Bytes held_back = host.sealed(host.command());
    host.ticks(150);
    EXPECT_FALSE(endpoint.alive(host.now));
    host.plain.hellos.clear();
    EXPECT_FALSE(host.done(held_back)) << "a command that an attacker kept for later";
    ASSERT_FALSE(host.plain.hellos.empty());
    EXPECT_EQ(host.plain.hellos.back().refusal, code(Refusal::seal_expired));
    ASSERT_TRUE(host.connect()) << "the same session goes on";
    EXPECT_FALSE(host.done(held_back));
    EXPECT_TRUE(host.done(host.sealed(host.command())));
}

TEST_F(Seal, AfterAResetNothingOfBeforeCounts) {
    ASSERT_TRUE(host.connect());
    const SealRequest request = host.request;
    const Bytes hello = host.hello_bytes;
    const Bytes command = host.sealed(host.command());
    for (const std::uint32_t boot : {1U, 2U}) {
        const auto after = sealed_endpoint(boot, 0x78);  // the same number of its start, once: entropy alone
        SealHost again(*after);
        again.request = request;
        again.tick(again.plain.framed(request));
        again.ticks(4);
        ASSERT_FALSE(again.plain.challenges.empty());
        EXPECT_NE(again.plain.challenges.back().nonce, host.challenge.nonce);
        again.plain.hellos.clear();
        EXPECT_FALSE(again.done(hello));
        EXPECT_FALSE(after->session_open());
        EXPECT_FALSE(again.done(command));
        EXPECT_FALSE(after->session_open());
        EXPECT_TRUE(again.connect(7));
        EXPECT_TRUE(again.done(again.sealed(again.command())));
    }
}

TEST_F(Seal, LostMessagesOfAnyNumberDoNotPutItOutOfStep) {
    ASSERT_TRUE(host.connect(7, 65'000));
    for (const std::uint64_t lost : {1U, 5U, 63U, 64U, 1000U, 30'000U, 60'000U, 65'000U}) {
        host.counter += lost;
        EXPECT_TRUE(host.done(host.sealed(host.command()))) << lost;
    }
    EXPECT_GT(host.counter, 200'000U) << "the counter has wrapped";
    EXPECT_EQ(endpoint.counters().seals.wrong, 0U);
}

TEST_F(Seal, AHostWithoutAKeyIsRefusedWithANumber) {
    host.tick(host.plain.framed(hello_of(7)));
    ASSERT_EQ(host.plain.hellos.size(), 1U);
    EXPECT_EQ(host.plain.hellos[0].refusal, code(Refusal::seal_required));
    EXPECT_FALSE(endpoint.session_open());
    EXPECT_FALSE(host.done(host.plain.framed(host.command())));
    Hello old = hello_of(7);
    old.schema = kSchemaHashes[1];
    old.minor = 1;
    host.tick(host.plain.framed(old));
    EXPECT_EQ(host.plain.hellos.back().refusal, code(Refusal::seal_required));
    EXPECT_FALSE(endpoint.session_open());
}

TEST_F(Seal, AControllerWithoutAKeyKnowsNoChallenge) {
    Endpoint plain(sc::reference_machine(), 1);
    SealHost keyed(plain);
    EXPECT_FALSE(keyed.ask(7));
    EXPECT_FALSE(keyed.done(keyed.plain.framed(keyed.hello())));
    EXPECT_FALSE(plain.session_open());
}

TEST_F(Seal, BothSidesProveThatTheyHaveTheKey) {
    ASSERT_TRUE(host.ask(7));
    EXPECT_TRUE(host.cell_proves_itself());
    EXPECT_EQ(host.challenge.blocks_per_s, 5000U);
    crypto::Key other = kTestKey;
    other[15] ^= 1;
    SealHost stranger(endpoint, other);
    stranger.now = host.now;
    ASSERT_TRUE(stranger.ask(8));
    EXPECT_FALSE(stranger.cell_proves_itself());
    EXPECT_FALSE(stranger.connect(8));
    EXPECT_FALSE(stranger.done(stranger.sealed(stranger.command())));
    EXPECT_FALSE(endpoint.session_open());
    EXPECT_GE(endpoint.counters().seals.wrong, 1U);
}

TEST_F(Seal, NoBitOfAMessageCanBeChanged) {
    ASSERT_TRUE(host.connect(7, 1000));
    // id, payload and tag, and the low bits of the counter, which stand for the whole.
    const std::size_t bits = 8 * (3 + largest_payload<Command>() + kSealTag);
    for (std::size_t bit = 0; bit < bits; ++bit) {
        host.tick(host.sealed(Heartbeat{1}));
        host.ticks(3);
        ASSERT_TRUE(endpoint.alive(host.now));
        EXPECT_FALSE(host.done(flipped(host.sealed(host.command()), bit))) << bit;
    }
    const SealCounters seals = endpoint.counters().seals;
    EXPECT_GE(seals.wrong + seals.stale, bits - 8) << "all but those that have become another kind of message";
    EXPECT_TRUE(host.done(host.sealed(host.command())));
}

TEST_F(Seal, NoBitOfTheHelloCanBeChanged) {
    ASSERT_TRUE(host.ask(7));
    const Bytes good = host.plain.framed(host.hello(5));
    for (std::size_t bit = 24; bit < 8 * (3 + largest_payload<SealHello>()); ++bit) {
        EXPECT_FALSE(host.done(flipped(good, bit)));
        EXPECT_FALSE(endpoint.session_open()) << bit;
    }
    host.tick(good);
    host.ticks(4);
    EXPECT_TRUE(endpoint.session_open());
}

TEST_F(Seal, AMessageCountsOnce) {
    ASSERT_TRUE(host.connect());
    Command first = host.command();
    const Bytes again = host.sealed(first);
    EXPECT_TRUE(host.done(again));
    first.sequence += 10;  // what a replay would be worth if requests were not known by their sequence
    const Bytes second = host.sealed(first);
    EXPECT_TRUE(host.done(second));
    const std::uint32_t heard = endpoint.counters().messages_repeated;
    const std::int64_t last = endpoint.last_heard();
    EXPECT_FALSE(host.done(again));
    EXPECT_FALSE(host.done(second));
    EXPECT_EQ(endpoint.counters().messages_repeated, heard + 2);
    EXPECT_EQ(endpoint.last_heard(), last) << "and keeps no session alive";
}

TEST_F(Seal, AHeartbeatThatIsReplayedKeepsNoSessionAlive) {
    ASSERT_TRUE(host.connect());
    const Bytes beat = host.sealed(Heartbeat{1});
    host.tick(beat);
    host.ticks(3);
    ASSERT_TRUE(endpoint.alive(host.now));
    for (int i = 0; i < 30; ++i) {
        host.tick(beat);
        host.ticks(4);
    }
    EXPECT_FALSE(endpoint.alive(host.now));
}

TEST_F(Seal, AMessageThatIsOvertakenDoesNotCount) {
    ASSERT_TRUE(host.connect());
    const Bytes first = host.sealed(host.command());
    const Bytes second = host.sealed(host.command());
    EXPECT_TRUE(host.done(second));
    EXPECT_FALSE(host.done(first));
    host.counter += 200;
    EXPECT_TRUE(host.done(host.sealed(host.command())));
    EXPECT_FALSE(host.done(first)) << "far behind is read as far ahead, and then its tag is another";
}

TEST_F(Seal, AMessageOfAnotherSessionDoesNotCount) {
    ASSERT_TRUE(host.connect(7, 0));
    const Bytes later = host.sealed(host.command(), 500);
    ASSERT_TRUE(host.connect(7, 0));
    EXPECT_FALSE(host.done(later)) << "the same session, opened again";
    host.ticks(150);
    ASSERT_TRUE(host.connect(8, 0));
    EXPECT_FALSE(host.done(later)) << "another session";
}

TEST_F(Seal, AHelloOpensOneSessionAndCannotSetTheCounterBack) {
    ASSERT_TRUE(host.connect(7, 10));
    const Bytes hello = host.hello_bytes;
    const Bytes command = host.sealed(host.command());
    EXPECT_TRUE(host.done(command));
    host.plain.hellos.clear();
    EXPECT_FALSE(host.done(hello));
    ASSERT_FALSE(host.plain.hellos.empty()) << "its answer may have been lost: it is given again";
    EXPECT_EQ(host.plain.hellos.back().refusal, 0U);
    EXPECT_FALSE(host.done(command)) << "and nothing else has come of it";
    host.ticks(150);
    EXPECT_FALSE(host.done(hello));
    EXPECT_FALSE(endpoint.alive(host.now)) << "after a silence it is worth nothing";
    EXPECT_FALSE(host.done(command));
}

TEST_F(Seal, ARepeatedRequestHasTheSameAnswerAndAnotherANewOne) {
    ASSERT_TRUE(host.ask(7));
    const SealChallenge first = host.challenge;
    host.plain.challenges.clear();
    host.tick(host.plain.framed(host.request));
    host.ticks(3);
    ASSERT_FALSE(host.plain.challenges.empty());
    EXPECT_EQ(host.plain.challenges.back().nonce, first.nonce);
    std::set<std::array<std::uint8_t, 16>> nonces{first.nonce};
    for (std::size_t i = 0; i < 100; ++i) {
        ASSERT_TRUE(host.ask(7));
        EXPECT_TRUE(nonces.insert(host.challenge.nonce).second);
    }
    EXPECT_TRUE(host.connect());
}

TEST_F(Seal, ARequestThatIsForgedDisturbsNoSession) {
    ASSERT_TRUE(host.connect());
    SealHost stranger(endpoint, {});
    stranger.now = host.now;
    ASSERT_TRUE(stranger.ask(99));
    stranger.tick(stranger.plain.framed(stranger.hello()));
    stranger.ticks(4);
    stranger.tick(stranger.plain.framed(hello_of(99)));
    host.now = stranger.now;
    EXPECT_TRUE(host.done(host.sealed(host.command())));
}

TEST_F(Seal, AnotherHostIsRefusedWhileOneIsHere) {
    ASSERT_TRUE(host.connect(7));
    ASSERT_TRUE(host.done(host.sealed(host.command())));
    EXPECT_FALSE(host.connect(8));
    EXPECT_EQ(host.plain.hellos.back().refusal, code(Refusal::wrong_state));
}

TEST_F(Seal, TheVerdictFallsAtTheSameTickHoweverThePlanStepIsCut) {
    std::array<std::vector<std::int64_t>, 2> ticks;
    for (std::size_t way = 0; way < 2; ++way) {
        const auto one = sealed_endpoint();
        SealHost speaker(*one);
        ASSERT_TRUE(speaker.connect());
        MapChunk chunk;
        chunk.sequence = 1;
        chunk.data.size = 224;
        Bytes bytes = speaker.sealed(chunk);
        const Bytes more = speaker.sealed(Command{.sequence = 2});
        bytes.insert(bytes.end(), more.begin(), more.end());
        one->receive(++speaker.now, bytes);
        for (int i = 0; i < 12; ++i) {
            LinkEvent event;
            while (one->poll(event)) {
                ticks.at(way).push_back(speaker.now);
            }
            one->check_seals();
            if (way == 1) {
                one->check_seals();  // a board that gives more has nothing of it
            }
            one->receive(++speaker.now, {});
        }
    }
    EXPECT_EQ(ticks[0].size(), 2U);
    EXPECT_EQ(ticks[0], ticks[1]);
}

TEST_F(Seal, WithoutAPlanStepTheSessionEnds) {
    ASSERT_TRUE(host.connect());
    const Bytes command = host.sealed(host.command());
    endpoint.receive(++host.now, command);
    endpoint.receive(++host.now, {});
    endpoint.receive(++host.now, {});
    EXPECT_FALSE(host.done({})) << "a board that is too slow does nothing rather than something at any tick";
}

TEST_F(Seal, WhatComesTooFastIsDroppedAndCounted) {
    ASSERT_TRUE(host.connect());
    MapChunk chunk;
    chunk.data.size = 224;
    Bytes flood;
    for (std::uint32_t i = 0; i < 8; ++i) {
        chunk.sequence = i + 1;
        const Bytes one = host.sealed(chunk);
        flood.insert(flood.end(), one.begin(), one.end());
    }
    host.tick(flood);
    host.ticks(40);
    EXPECT_EQ(endpoint.counters().seals.dropped, 4U) << "1 kB is there, for four of these";
    EXPECT_EQ(endpoint.counters().messages_lost, 0U);
    LinkEvent event;
    int taken = 0;
    while (endpoint.poll(event)) {
        ++taken;
    }
    EXPECT_EQ(taken, 4);
    EXPECT_TRUE(host.done(host.sealed(Command{.sequence = 100}))) << "and the session goes on";
    EXPECT_EQ(endpoint.counters().messages_lost, 4U);
}

TEST_F(Seal, OfThousandsOfForgedMessagesNoneComesThrough) {
    ASSERT_TRUE(host.connect());
    std::mt19937_64 random(11);
    std::vector<Bytes> heard;
    std::uint32_t sequence = 0;
    std::uint32_t taken = 0;
    for (int round = 0; round < 5000; ++round) {
        Bytes bytes;
        if (round % 10 == 0) {
            heard.push_back(host.sealed(Command{.sequence = ++sequence}));
            bytes = heard.back();
        }
        Bytes forged;
        if (round % 3 == 0) {
            forged = heard[random() % heard.size()];
            forged = round % 2 == 0 ? forged : flipped(forged, 24 + random() % 200);
        } else {
            // id, counter, payload of any length: checksum right, all else made up.
            Bytes plain{static_cast<std::uint8_t>(random() % 26), static_cast<std::uint8_t>(random()),
                        static_cast<std::uint8_t>(random())};
            for (std::size_t size = random() % 50; size > 0; --size) {
                plain.push_back(static_cast<std::uint8_t>(random()));
            }
            forged = framed_again(plain);
        }
        bytes.insert(bytes.end(), forged.begin(), forged.end());
        host.tick(bytes);
        host.ticks(2);
        LinkEvent event;
        while (endpoint.poll(event)) {
            ASSERT_EQ(event.kind, LinkEvent::Kind::command) << round;
            ASSERT_EQ(event.command.sequence, ++taken) << round;
            endpoint.reply(taken, Refusal::none, 0);
        }
    }
    host.ticks(10);
    EXPECT_GE(taken + 1, sequence);
    EXPECT_GT(endpoint.counters().seals.wrong, 2000U);
    EXPECT_GT(endpoint.counters().seals.stale, 500U);
}

TEST_F(Seal, TheQueueTakesMessagesOfAllLengthsInOrder) {
    ASSERT_TRUE(host.connect());
    std::uint32_t sequence = 0;
    std::uint32_t wanted = 0;
    for (int round = 0; round < 400; ++round) {
        MapChunk chunk;
        chunk.sequence = ++sequence;
        chunk.data.size = static_cast<std::uint8_t>(static_cast<unsigned>(round * 37) % 225U);
        Bytes bytes = host.sealed(chunk);
        if (round % 3 == 0) {
            const Bytes beat = host.sealed(Heartbeat{1});
            bytes.insert(bytes.end(), beat.begin(), beat.end());
        }
        host.tick(bytes);
        for (int i = 0; i < 5; ++i) {
            LinkEvent event;
            while (endpoint.poll(event)) {
                EXPECT_EQ(event.map_chunk.sequence, ++wanted);
                endpoint.reply(event.map_chunk.sequence, Refusal::none, 0);
            }
            if (i < 4) {
                host.tick();
            }
        }
    }
    EXPECT_EQ(endpoint.counters().seals.dropped, 0U);
    EXPECT_GE(wanted, 398U);
}

}  // namespace
