// SPDX-License-Identifier: Apache-2.0
// What an endpoint tells beyond the job: the clock, telemetry within its share of the line, the black box.
#include "shared/link/telemetry.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/link/endpoint.hpp"
#include "link_host.hpp"
#include "shared/link/blackbox.hpp"

namespace {

using namespace sc::link;  // NOLINT(google-build-using-namespace): the subject of this file
using sc::Refusal;

constexpr std::uint32_t kLine = 92'160;
constexpr std::uint32_t kPeriodNs = 1'000'000;

TelemetryRequest wanted(std::uint32_t channels, std::uint16_t ticks, std::uint32_t line = kLine) {
    TelemetryRequest request;
    request.sequence = 10;
    request.channels = channels;
    request.period_ticks.fill(ticks);
    request.line_bytes_per_s = line;
    return request;
}

class TelemetryTest : public testing::Test {
protected:
    TelemetryTest() { connect(kProtocolMinor); }
    void connect(std::uint8_t minor) {
        Hello hello = hello_of(7);
        hello.schema = kSchemaHashes[minor];
        hello.minor = minor;
        host.set_minor(minor);
        host.send(endpoint, tick, hello);
        LinkEvent event;
        EXPECT_TRUE(endpoint.poll(event));
        host.collect(endpoint);
        host.clear();
    }
    /// As a controller does it each tick; the host keeps the session alive.
    std::size_t step() {
        if (++tick % 20 == 0) {
            host.send(endpoint, tick, Heartbeat{static_cast<std::uint64_t>(tick)});
        } else {
            endpoint.receive(tick, {});
        }
        std::vector<std::uint8_t> bytes(1024);
        std::size_t size = endpoint.transmit(bytes);
        if (endpoint.telemetry_due() != 0) {
            TelemetryValues values;
            values.set_point = {1, -2, 3, static_cast<std::int32_t>(tick)};
            values.queue = 77;
            values.triple = {4, 5, -6};
            const std::size_t more = endpoint.transmit(std::span(bytes).subspan(size), values);
            telemetry_bytes += more;
            size += more;
        }
        host.take(std::span(bytes).first(size));
        return size;
    }
    CommandReply ask(const TelemetryRequest& request) {
        host.send(endpoint, tick, request);
        host.collect(endpoint);
        EXPECT_EQ(host.replies.size(), 1U);
        const CommandReply reply = host.replies.empty() ? CommandReply{} : host.replies.back();
        host.clear();
        return reply;
    }

    std::unique_ptr<Endpoint> owned = std::make_unique<Endpoint>(sc::reference_machine(), 99);
    Endpoint& endpoint = *owned;
    LinkHost host;
    std::int64_t tick = 1000;
    std::uint32_t session = 7;
    std::size_t telemetry_bytes = 0;
};

TEST_F(TelemetryTest, AHeartbeatIsAnsweredWithTheTimesOfTheCell) {
    host.send(endpoint, 1234, Heartbeat{4711});
    host.collect(endpoint, 10);  // no room
    endpoint.receive(1236, {});
    host.collect(endpoint);
    ASSERT_EQ(host.clocks.size(), 1U);
    EXPECT_EQ(host.clocks[0].host_time_us, 4711U);
    EXPECT_EQ(host.clocks[0].received_us, 1'234'000U);
    EXPECT_EQ(host.clocks[0].sent_us, 1'236'000U);
    host.send(endpoint, 1234 + Endpoint::kClockEveryTicks - 1, Heartbeat{4712});
    host.collect(endpoint);
    EXPECT_EQ(host.clocks.size(), 1U) << "some of them are enough";
    host.send(endpoint, 1234 + Endpoint::kClockEveryTicks, Heartbeat{4713});
    host.collect(endpoint);
    EXPECT_EQ(host.clocks.size(), 2U);
}

TEST_F(TelemetryTest, AHostOfAnOlderVersionHearsNothingOfIt) {
    connect(0);
    for (int i = 0; i < 300; ++i) {
        step();
    }
    connect(1);
    for (int i = 0; i < 300; ++i) {
        step();
    }
    EXPECT_TRUE(host.clocks.empty());
    EXPECT_EQ(host.frames_bad(), 0U);
    EXPECT_EQ(host.malformed, 0);
}

TEST_F(TelemetryTest, ChannelsComeAtTheirPeriodInTheOrderOfTheTable) {
    const std::uint32_t channels = telemetry_bit(TelemetryChannel::set_point) | telemetry_bit(TelemetryChannel::queue) |
                                   telemetry_bit(TelemetryChannel::triple);
    TelemetryRequest request = wanted(channels, 10);
    request.period_ticks = {10, 50, 60'000, 100};
    EXPECT_EQ(ask(request).refusal, 0U);
    for (int i = 0; i < 1000; ++i) {
        step();
    }
    ASSERT_EQ(host.telemetry.size(), 101U) << "one at once";
    std::size_t queues = 0;
    for (const Telemetry& sample : host.telemetry) {
        ASSERT_EQ(sample.values.size, telemetry_value_bytes(sample.channels));
        queues += (sample.channels & telemetry_bit(TelemetryChannel::queue)) != 0 ? 1U : 0U;
        EXPECT_EQ(sample.skipped, 0U);
    }
    EXPECT_EQ(queues, 21U);
    const Telemetry& first = host.telemetry[0];
    EXPECT_EQ(first.channels, channels);
    sc::ByteReader reader(std::span(first.values.data).first(first.values.size));
    EXPECT_EQ(reader.get<std::int32_t>(), 1);
    EXPECT_EQ(reader.get<std::int32_t>(), -2);
    EXPECT_EQ(reader.get<std::int32_t>(), 3);
    EXPECT_EQ(reader.get<std::int32_t>() * 1000, static_cast<std::int32_t>(first.cell_time_us));
    EXPECT_EQ(reader.get<std::uint16_t>(), 77U);
    EXPECT_EQ(reader.get<std::int32_t>(), 4);
    EXPECT_EQ(reader.get<std::int32_t>(), 5);
    EXPECT_EQ(reader.get<std::int32_t>(), -6);
    EXPECT_TRUE(reader.exhausted());
}

TEST_F(TelemetryTest, WhatTakesMoreThanItsShareIsRefusedWithWhatWouldFit) {
    for (const std::uint32_t line : {0U, 3840U, 11'520U, kLine, 300'000U}) {
        const TelemetryRequest all = wanted(kTelemetryChannels, kTelemetryShortest, line);
        const CommandReply reply = ask(all);
        ASSERT_EQ(reply.refusal, static_cast<std::uint16_t>(Refusal::telemetry_over_budget)) << line;
        TelemetryRequest fitting = all;
        fitting.sequence = 11;
        fitting.period_ticks.fill(static_cast<std::uint16_t>(reply.detail));
        EXPECT_LE(telemetry_bytes_per_s(fitting, kPeriodNs, 1), telemetry_budget(line));
        fitting.period_ticks.fill(static_cast<std::uint16_t>(reply.detail - 1));
        EXPECT_GT(telemetry_bytes_per_s(fitting, kPeriodNs, 1), telemetry_budget(line)) << "it is the least";
        fitting.period_ticks.fill(static_cast<std::uint16_t>(reply.detail));
        EXPECT_EQ(ask(fitting).refusal, 0U) << line;
        tick += 200;
        host.send(endpoint, tick, hello_of(++session));
        host.collect(endpoint);
        host.clear();
        LinkEvent event;
        while (endpoint.poll(event)) {
        }
    }
}

TEST_F(TelemetryTest, UnknownChannelsAndPeriodsThatAreNoneAreRefused) {
    CommandReply reply = ask(wanted(kTelemetryChannels + 1, 100));
    EXPECT_EQ(reply.refusal, static_cast<std::uint16_t>(Refusal::bad_config));
    EXPECT_EQ(reply.detail, 1);
    TelemetryRequest request = wanted(telemetry_bit(TelemetryChannel::state), 1);
    request.sequence = 11;
    reply = ask(request);
    EXPECT_EQ(reply.refusal, static_cast<std::uint16_t>(Refusal::bad_config));
    EXPECT_EQ(reply.detail, 2);
    for (int i = 0; i < 100; ++i) {
        step();
    }
    EXPECT_TRUE(host.telemetry.empty());
}

TEST_F(TelemetryTest, KeepsItsShareAndLeavesWhatIsMoreUrgentAlone) {
    // A line of 115 200 baud, nearly filled by acknowledgements and states.
    constexpr std::uint32_t kSlow = 11'520;
    TelemetryRequest request = wanted(telemetry_bit(TelemetryChannel::actual), 20, kSlow);
    ASSERT_EQ(ask(request).refusal, 0U);
    endpoint.open_job(1, 100'000);
    double waiting = 0.0;  // bytes in the carrier
    double worst = 0.0;
    std::size_t acks = 0;
    for (std::uint32_t i = 0; i < 4000; ++i) {
        endpoint.progress(i, i, {});
        if (i % 20 == 0) {
            endpoint.status({});
        }
        const std::size_t telemetry_before = telemetry_bytes;
        const auto sent = static_cast<double>(step());
        const auto telemetry = static_cast<double>(telemetry_bytes - telemetry_before);
        if (telemetry > 0) {
            worst = std::max(worst, waiting + sent - telemetry);
        }
        acks += host.acks.size();
        host.acks.clear();
        waiting = std::max(0.0, waiting + sent - kSlow * 1e-3);
    }
    EXPECT_GE(acks, 4000U / Endpoint::kAckEveryTicks - 20U);
    EXPECT_LE(worst, 2.0 * kSlow * 1e-3) << "a sample has left onto a line that was busy";
    EXPECT_LE(static_cast<double>(telemetry_bytes), 4.0 * kSlow / kTelemetryPart);
    ASSERT_FALSE(host.telemetry.empty());
    EXPECT_GT(host.telemetry.back().skipped, 0U) << "and what was left out is told";
}

TEST_F(TelemetryTest, EndsByARequestWithTheSessionAndInSilence) {
    const std::uint32_t state = telemetry_bit(TelemetryChannel::state);
    TelemetryRequest request = wanted(state, 10);
    ASSERT_EQ(ask(request).refusal, 0U);
    for (int i = 0; i < 100; ++i) {
        step();
    }
    EXPECT_EQ(host.telemetry.size(), 11U);
    request.sequence = 11;
    request.channels = 0;
    ASSERT_EQ(ask(request).refusal, 0U);
    for (int i = 0; i < 100; ++i) {
        step();
    }
    EXPECT_TRUE(host.telemetry.empty());
    request.sequence = 12;
    request.channels = state;
    ASSERT_EQ(ask(request).refusal, 0U);
    tick += 102;
    endpoint.receive(tick, {});
    host.collect(endpoint);
    EXPECT_EQ(endpoint.telemetry_due(), 0U) << "nobody is there";
    host.send(endpoint, tick, hello_of(8));
    for (int i = 0; i < 100; ++i) {
        step();
    }
    EXPECT_TRUE(host.telemetry.empty()) << "another host has not asked for it";
}

TEST_F(TelemetryTest, ARequestForTheBlackBoxStaysUntilItIsAnswered) {
    host.send(endpoint, tick, BlackboxRequest{1, 42});
    ASSERT_TRUE(endpoint.blackbox_wanted().has_value());
    EXPECT_EQ(endpoint.blackbox_wanted()->first, 42U);
    std::vector<std::uint8_t> bytes(1024);
    EXPECT_EQ(endpoint.transmit(std::span(bytes).first(100), BlackboxChunk{}), 0U);
    ASSERT_TRUE(endpoint.blackbox_wanted().has_value()) << "there was no room";
    host.take(std::span(bytes).first(endpoint.transmit(bytes, BlackboxChunk{.first = 42})));
    EXPECT_FALSE(endpoint.blackbox_wanted().has_value());
    ASSERT_EQ(host.boxes.size(), 1U);
    EXPECT_EQ(host.boxes[0].first, 42U);
}

TEST(BlackboxRecords, ComeBackAsTheyWere) {
    for (const std::int32_t place : {0, 1, -1, 8'388'607, -8'388'607}) {
        BlackboxSample sample;
        sample.tick = 65'535;
        sample.actual = {place, -place, place / 2, 3};
        sample.error = {-32'767, 32'767, 0, -1};
        sample.state = 9;
        sample.limited_by = 206;
        sample.override_percent = 200;
        sample.flags = 255;
        sample.queue = 2048;
        sample.pulses = 65'535;
        std::array<std::uint8_t, BlackboxSample::kBytes> bytes{};
        pack(sample, bytes);
        EXPECT_EQ(unpack_sample(bytes), sample);
    }
    const BlackboxEvent event{0xFFFF'FFFE, 3, 255, 65'000};
    std::array<std::uint8_t, BlackboxEvent::kBytes> bytes{};
    pack(event, bytes);
    EXPECT_EQ(unpack_event(bytes), event);
}

}  // namespace
