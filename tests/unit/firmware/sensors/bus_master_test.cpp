// SPDX-License-Identifier: Apache-2.0
#include "firmware/sensors/bus_master.hpp"

#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/sensors/modbus_rtu.hpp"

namespace {

using namespace sc;
using namespace sc::sensors;

constexpr std::int64_t kPeriod = 1'000'000;
constexpr SensorBusConfig kBus{115'200, SensorParity::even, 0, 0};
constexpr std::int64_t kPatience = 20'000'000;

/// A master whose ticks are driven by hand: bytes are given by their absolute times.
class Bench {
public:
    explicit Bench(const SensorBusConfig& bus = kBus) : master(bus, kPeriod) {}

    /// The next tick, with the bytes that have ended until it.
    std::optional<Reply> tick() {
        ++n;
        std::vector<SensorByte> now;
        while (!coming.empty() && coming.front().first <= n * kPeriod) {
            SensorByte byte = coming.front().second;
            byte.age_us = static_cast<std::uint16_t>((n * kPeriod - coming.front().first) / 1000);
            now.push_back(byte);
            coming.erase(coming.begin());
        }
        Reply reply;
        return master.step(n * kPeriod, now, reply) ? std::optional(reply) : std::nullopt;
    }
    /// Ticks until a telegram has ended, 3000 at most.
    std::optional<Reply> until_reply() {
        for (int i = 0; i < 3000; ++i) {
            if (auto reply = tick()) {
                return reply;
            }
        }
        return std::nullopt;
    }
    /// Sends now; the end of the request.
    std::int64_t send(const Telegram& telegram) {
        EXPECT_TRUE(master.can_send(n * kPeriod));
        master.send(n * kPeriod, telegram, out);
        begin = (n + 1) * kPeriod + out.delay_ns;
        EXPECT_LT(out.delay_ns, kPeriod);
        return begin + out.size * master.timing().character;
    }
    /// An answer whose first start bit begins at `at`; its end.
    std::int64_t answer(std::int64_t at, const std::vector<std::uint8_t>& bytes) {
        for (const std::uint8_t byte : bytes) {
            at += master.timing().character;
            coming.emplace_back(at, SensorByte{byte, 0, 0});
        }
        return at;
    }

    BusMaster master;
    SensorTransmission out;
    std::vector<std::pair<std::int64_t, SensorByte>> coming;
    std::int64_t n = 100;
    std::int64_t begin = 0;
};

Telegram question() {
    Telegram telegram = modbus::read(1, 4, 6, 1, kPatience);
    telegram.tag = 7;
    return telegram;
}
std::vector<std::uint8_t> value() { return {1, 4, 2, 0x12, 0x34, 0xB4, 0x47}; }

TEST(BusMaster, TimesAreTheStandards) {
    const BusTiming slow = bus_timing({9'600, SensorParity::even, 0, 0});
    EXPECT_EQ(slow.character, 1'145'833);
    EXPECT_EQ(slow.inner, slow.character * 3 / 2);
    EXPECT_EQ(slow.gap, slow.character * 7 / 2);
    EXPECT_EQ(bus_timing(kBus).inner, 750'000);
    EXPECT_EQ(bus_timing(kBus).gap, 1'750'000);
    EXPECT_EQ(bus_timing({115'200, SensorParity::none, 1, 0}).gap, 86'805 * 7 / 2);
}

TEST(BusMaster, AnAnswerIsGoodOnceSilenceHasFollowedAndTheNextRequestWaitsForNothingElse) {
    Bench bench;
    const std::int64_t asked = bench.send(question());
    const std::int64_t end = bench.answer(asked + 2'000'000, value());
    std::optional<Reply> reply;
    std::int64_t sent_at = 0;
    while (!reply || sent_at == 0) {
        if (auto now = bench.tick()) {
            reply = now;
            EXPECT_GE(bench.n * kPeriod, end + 1'750'000);
            EXPECT_LT(bench.n * kPeriod, end + 1'750'000 + kPeriod);
        }
        if (sent_at == 0 && bench.master.can_send(bench.n * kPeriod)) {
            bench.send(question());
            sent_at = bench.begin;
        }
        ASSERT_LT(bench.n, 200);
    }
    EXPECT_EQ(reply->code, SensorCode::none);
    EXPECT_EQ(reply->tag, 7);
    EXPECT_EQ(modbus::register_of(reply->view(), 0), 0x1234);
    EXPECT_EQ(reply->asked_ns, asked);
    // Either right after the silence, or at the beginning of the first window that could still be given.
    EXPECT_GE(sent_at, end + 1'750'000);
    EXPECT_LE(sent_at, end + 2'000'000);
}

TEST(BusMaster, NobodyAnswers) {
    Bench bench;
    const std::int64_t asked = bench.send(question());
    const auto reply = bench.until_reply();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->code, SensorCode::timeout);
    EXPECT_GE(bench.n * kPeriod, asked + kPatience);
    EXPECT_LE(bench.n * kPeriod, asked + kPatience + 2 * kPeriod);
    // Who is late must not be taken for the answer to the next request.
    const std::int64_t over = bench.n;
    bench.answer(bench.n * kPeriod + 5'000'000, value());
    while (!bench.master.can_send(bench.n * kPeriod)) {
        EXPECT_FALSE(bench.tick());
        ASSERT_LT(bench.n, over + 100);
    }
    EXPECT_GE(bench.n * kPeriod, over * kPeriod + kPatience - kPeriod);
    EXPECT_EQ(bench.master.strays(), 7U);
}

TEST(BusMaster, APauseOfMoreThanOneAndAHalfCharactersBreaksAnAnswer) {
    for (const std::int64_t pause : {740'000, 760'000}) {
        Bench bench;
        const std::int64_t asked = bench.send(question());
        const std::int64_t half = bench.answer(asked + 2'000'000, {1, 4, 2});
        bench.answer(half + pause, {0x12, 0x34, 0xB4, 0x47});
        const auto reply = bench.until_reply();
        ASSERT_TRUE(reply);
        EXPECT_EQ(reply->code, pause < 750'000 ? SensorCode::none : SensorCode::bad_frame) << pause;
    }
}

TEST(BusMaster, AnAnswerThatStopsShortIsNone) {
    Bench bench;
    const std::int64_t asked = bench.send(question());
    bench.answer(asked + 2'000'000, {1, 4, 2, 0x12});
    const auto reply = bench.until_reply();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->code, SensorCode::bad_frame);
}

TEST(BusMaster, AByteTooManySpoilsAnAnswerEvenWhenTheNextRequestIsOnItsWay) {
    Bench bench;
    const std::int64_t asked = bench.send(question());
    const std::int64_t end = bench.answer(asked + 2'000'000, value());
    bench.answer(end + 1'000'000, {0x55});
    std::optional<Reply> reply;
    bool again = false;
    while (!reply) {
        reply = bench.tick();
        if (!again && bench.master.can_send(bench.n * kPeriod)) {
            bench.send(question());
            again = true;
        }
        ASSERT_LT(bench.n, 200);
    }
    EXPECT_TRUE(again);
    EXPECT_EQ(reply->code, SensorCode::bad_frame);
    // The second one has its own outcome.
    bench.answer(bench.begin + 8 * bench.master.timing().character + 2'000'000, value());
    reply = bench.until_reply();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->code, SensorCode::none);
}

TEST(BusMaster, ParityAndFramingErrorsAreBadFrames) {
    Bench bench;
    const std::int64_t asked = bench.send(question());
    bench.answer(asked + 2'000'000, value());
    bench.coming[4].second.flags = 1;
    const auto reply = bench.until_reply();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->code, SensorCode::bad_frame);
}

TEST(BusMaster, TheLineTurningRoundIsNotTheAnswer) {
    Bench bench;
    const std::int64_t asked = bench.send(question());
    bench.answer(asked + 10'000, {0xFF});
    bench.answer(asked + 3'000'000, value());
    const auto reply = bench.until_reply();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->code, SensorCode::none);
    EXPECT_EQ(bench.master.strays(), 1U);
}

TEST(BusMaster, ABroadcastEndsByItselfAndNothingIsTakenForItsAnswer) {
    Bench bench;
    Telegram latch = modbus::write(0, 41, 1, 3'500'000);
    latch.tag = 4;
    const std::int64_t asked = bench.send(latch);
    const auto reply = bench.until_reply();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->code, SensorCode::none);
    EXPECT_EQ(reply->tag, 4);
    EXPECT_EQ(reply->size, 0);
    EXPECT_EQ(reply->asked_ns, asked);
    EXPECT_TRUE(bench.master.can_send(bench.n * kPeriod));
}

TEST(BusMaster, ALineThatBabblesIsLeftAloneUntilItIsSilent) {
    Bench bench;
    const std::int64_t asked = bench.send(question());
    std::vector<std::uint8_t> noise(200, 0xA5);
    const std::int64_t end = bench.answer(asked + 2'000'000, noise);
    const auto reply = bench.until_reply();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->code, SensorCode::bad_frame);
    while (bench.n * kPeriod < end + 1'750'000) {
        EXPECT_FALSE(bench.master.can_send(bench.n * kPeriod));
        (void)bench.tick();
    }
    (void)bench.tick();
    EXPECT_TRUE(bench.master.can_send(bench.n * kPeriod));
}

}  // namespace
