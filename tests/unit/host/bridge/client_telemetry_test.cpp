// SPDX-License-Identifier: Apache-2.0
#include <string>

#include <gtest/gtest.h>

#include "host/bridge/client.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/bridge/telemetry_values.hpp"
#include "host/formats/error.hpp"
#include "shared/link/telemetry.hpp"
#include "tests/unit/host/bridge/fake_cell.hpp"

namespace sc::host {
namespace {

using test::FakeCell;

constexpr Nanoseconds kSecond{1'000'000'000};

ClientOptions options() {
    ClientOptions o;
    o.session = 4711;
    return o;
}

TEST(ClientClock, IsFittedFromTheAnswersToHeartbeats) {
    FakeCell cell({.drop = 0.2, .delay = Nanoseconds(3'000'000), .seed = 5});
    cell.clock_ahead = 77 * kSecond;
    CellClient client(cell, options());
    client.connect();
    client.pump_until([] { return false; }, 2 * kSecond);
    const auto estimate = client.clock().at(client.now());
    ASSERT_TRUE(estimate.has_value());
    EXPECT_NEAR(estimate->offset_s, 77.0, 1e-4);
    EXPECT_NEAR(estimate->uncertainty_s, 3e-3, 1e-3);
    EXPECT_NEAR(estimate->round_trip_s, 6e-3, 1e-4);
    EXPECT_GT(estimate->samples, 20U);
}

TEST(ClientClock, StaysEmptyWithAnOlderController) {
    FakeCell cell;
    cell.clock_ahead = kSecond;
    cell.minor = 1;
    cell.schema = link::kSchemaHashes[1];
    CellClient client(cell, options());
    client.connect();
    client.pump_until([] { return false; }, kSecond);
    EXPECT_EQ(client.minor(), 1);
    EXPECT_FALSE(client.clock().at(client.now()).has_value());
    client.subscribe({});
    EXPECT_THROW(client.subscribe({.channels = 1}), CellRefused);
    EXPECT_THROW((void)client.read_black_box(), CellRefused);
    EXPECT_FALSE(cell.telemetry.has_value());
}

TEST(ClientTelemetry, SubscribesAndTellsWhatWouldFit) {
    FakeCell cell({.drop = 0.3, .seed = 3});
    CellClient client(cell, options());
    client.connect();
    client.subscribe({.channels = 5, .period_ticks = {10, 0, 0, 0}, .line_bytes_per_s = 92'160});
    ASSERT_TRUE(cell.telemetry.has_value());
    EXPECT_EQ(cell.telemetry->channels, 5U);
    EXPECT_EQ(cell.telemetry->period_ticks[0], 10);
    cell.refuse_telemetry = Refusal::telemetry_over_budget;
    try {
        client.subscribe({.channels = 5, .period_ticks = {2, 0, 0, 0}});
        FAIL() << "accepted";
    } catch (const CellRefused& refused) {
        EXPECT_EQ(refused.refusal, Refusal::telemetry_over_budget);
    }
}

TEST(TelemetryValues, AreDecodedByTheTableOrNotAtAll) {
    link::Telemetry sample;
    sample.channels = link::telemetry_bit(link::TelemetryChannel::actual) |
                      link::telemetry_bit(link::TelemetryChannel::queue) |
                      link::telemetry_bit(link::TelemetryChannel::pulses);
    ByteWriter writer(sample.values.data);
    for (const std::int32_t place : {-100'000, 200'000, 0, 9'000'000}) {
        writer.put(place);
    }
    writer.put(std::uint16_t{2048});
    writer.put(std::uint32_t{0xFFFF'FFFF});
    sample.values.size = static_cast<std::uint8_t>(writer.size());
    const auto values = decode(sample);
    ASSERT_TRUE(values.has_value());
    ASSERT_EQ(values->size(), 6U);
    EXPECT_EQ(column_name(values->at(0).column, values->at(0).element), "actual_x_mm");
    EXPECT_DOUBLE_EQ(values->at(0).value(), -1.0);
    EXPECT_EQ(column_name(values->at(3).column, values->at(3).element), "actual_c_deg");
    EXPECT_DOUBLE_EQ(values->at(3).value(), 90.0);
    EXPECT_DOUBLE_EQ(values->at(4).value(), 2048.0);
    EXPECT_DOUBLE_EQ(values->at(5).value(), 4'294'967'295.0);
    link::Telemetry cut = sample;
    --cut.values.size;
    EXPECT_FALSE(decode(cut).has_value());
    cut.values.size = static_cast<std::uint8_t>(sample.values.size + 1);
    EXPECT_FALSE(decode(cut).has_value());
    link::Telemetry unknown = sample;
    unknown.channels |= link::kTelemetryChannels + 1;
    EXPECT_FALSE(decode(unknown).has_value());
    EXPECT_EQ(read_channels("all"), link::kTelemetryChannels);
    EXPECT_EQ(read_channels("actual,queue,pulses"), sample.channels);
    EXPECT_THROW((void)read_channels("actual,depht"), InputError);
    EXPECT_THROW((void)read_channels(""), InputError);
}

TEST(LineRate, FollowsFromTheUrl) {
    EXPECT_EQ(line_bytes_per_s("serial:/dev/ttyUSB0?baud=115200", {}), 11'520U);
    EXPECT_EQ(line_bytes_per_s("serial:/dev/ttyUSB0", {}), 0U);
    EXPECT_EQ(line_bytes_per_s("sim:", {}), 92'160U);
    LinkOptions slow;
    slow.baud = 115'200;
    EXPECT_EQ(line_bytes_per_s("sim:", slow), 11'520U);
    EXPECT_THROW((void)line_bytes_per_s("can0", {}), InputError);
}

TEST(ClientBlackBox, IsReadWholeOverALossyLink) {
    FakeCell cell({.drop = 0.2, .repeat = 0.1, .corrupt = 0.1, .seed = 8});
    cell.black_box.frozen = 1;
    cell.black_box.fault = static_cast<std::uint8_t>(Fault::following_error);
    cell.black_box.axis = 2;
    cell.black_box.period_ns = 1'000'000;
    constexpr std::uint32_t kNewest = 3 * 65'536 + 100;  // ticks: the records' own begin anew on the way
    cell.black_box.newest_us = kNewest * 1000ULL;
    for (std::uint32_t i = 0; i < 250; ++i) {
        link::BlackboxSample sample;
        sample.tick = static_cast<std::uint16_t>((kNewest - 40 * (249 - i)) & 0xFFFFU);
        sample.actual = {-static_cast<std::int32_t>(i), 1, -8'388'607, 8'388'607};
        sample.error = {-32'767, 0, 1, 32'767};
        sample.pulses = static_cast<std::uint16_t>(i);
        cell.box_samples.push_back(sample);
    }
    for (std::uint32_t i = 0; i < 60; ++i) {
        cell.box_events.push_back({kNewest - 59 + i, static_cast<std::uint8_t>(link::BlackboxKind::command), 5, 103});
    }
    CellClient client(cell, options());
    client.connect();
    const BlackBoxContent content = client.read_black_box();
    EXPECT_TRUE(content.frozen);
    EXPECT_EQ(content.fault, Fault::following_error);
    EXPECT_EQ(content.axis, 2);
    ASSERT_EQ(content.samples.size(), 250U);
    for (std::size_t i = 0; i < 250; ++i) {
        EXPECT_EQ(content.samples[i].at, cell.box_samples[i]);
        EXPECT_NEAR(content.samples[i].cell_s, (kNewest - 40.0 * (249.0 - static_cast<double>(i))) * 1e-3, 1e-9);
    }
    ASSERT_EQ(content.events.size(), 60U);
    EXPECT_EQ(content.events[0].what, cell.box_events[0]);
    EXPECT_NEAR(content.events[0].cell_s, (kNewest - 59) * 1e-3, 1e-9);
}

TEST(ClientBlackBox, RecordsOfAMessageThatClaimsTooManyAreDropped) {
    link::BlackboxChunk chunk;
    chunk.end = 20;
    chunk.count = 8;
    chunk.period_ns = 1'000'000;
    BlackBoxContent content;
    EXPECT_EQ(take_chunk(chunk, content), 20U);
    EXPECT_TRUE(content.samples.empty());
    chunk.count = 7;
    EXPECT_EQ(take_chunk(chunk, content), 7U);
    EXPECT_EQ(content.samples.size(), 7U);
    chunk.begin = 3;
    EXPECT_EQ(take_chunk(chunk, content), 3U) << "overwritten meanwhile";
}

}  // namespace
}  // namespace sc::host
