// SPDX-License-Identifier: Apache-2.0
// Telemetry, the clock and the black box on the simulated cell.
#include "shared/link/telemetry.hpp"

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "cell_rig.hpp"
#include "firmware/recording/digest.hpp"
#include "shared/link/blackbox.hpp"
#include "undisturbed.hpp"

namespace {

using namespace sc;
using test::CellRig;
using test::short_job;
using test::undisturbed;

link::TelemetryRequest everything(std::uint16_t motion_ticks) {
    link::TelemetryRequest request;
    request.channels = link::kTelemetryChannels;
    request.period_ticks = {motion_ticks, 20, 50, 50};
    request.line_bytes_per_s = 92'160;
    return request;
}

struct JobRun {
    std::unique_ptr<CellRig> rig;
    std::vector<recording::OutputsDigest> digests;  ///< of each tick, from the start of the job on
};

JobRun run_job(const link::TelemetryRequest& request) {
    JobRun run;
    run.rig = std::make_unique<CellRig>();
    CellRig& rig = *run.rig;
    rig.make_ready();
    EXPECT_EQ(rig.subscribe(request).refusal, 0);
    rig.ticks(37);
    EXPECT_EQ(rig.open_job(short_job()).refusal, 0);
    auto digester = std::make_unique<recording::OutputsDigester>();
    rig.watch([&] { run.digests.push_back(digester->digest(rig.cell().latest())); });
    EXPECT_EQ(rig.command(link::Verb::start).refusal, 0);
    EXPECT_TRUE(rig.until([&] { return (rig.status().flags & link::kFlagJobDone) != 0; }));
    rig.watch({});
    return run;
}

TEST(Telemetry, ChangesNothingOfWhatTheCellDoes) {
    const JobRun off = run_job({});
    const JobRun on = run_job(everything(12));
    EXPECT_TRUE(off.rig->telemetry().empty());
    EXPECT_GT(on.rig->telemetry().size(), on.digests.size() / 12);
    EXPECT_EQ(on.rig->command_hash(), undisturbed().command_hash());
    EXPECT_EQ(off.rig->command_hash(), undisturbed().command_hash());
    // Every part of every tick but the bytes to the host.
    const std::size_t ticks = std::min(on.digests.size(), off.digests.size());
    ASSERT_GT(ticks, 1000U);
    constexpr auto kLinkPart = static_cast<std::size_t>(recording::OutputPart::link);
    bool link_differs = false;
    for (std::size_t t = 0; t < ticks; ++t) {
        for (std::size_t part = 0; part < recording::kOutputParts; ++part) {
            const bool same = on.digests[t].check[part] == off.digests[t].check[part];
            link_differs = link_differs || (part == kLinkPart && !same);
            ASSERT_TRUE(same || part == kLinkPart) << "tick " << t << ", part " << part;
        }
    }
    EXPECT_TRUE(link_differs);
}

TEST(Telemetry, TellsWhatTheCellDoes) {
    CellRig rig;
    rig.make_ready();
    link::TelemetryRequest request;
    request.channels = link::telemetry_bit(link::TelemetryChannel::set_point) |
                       link::telemetry_bit(link::TelemetryChannel::actual) |
                       link::telemetry_bit(link::TelemetryChannel::following_error);
    request.period_ticks = {10, 0, 0, 0};
    request.line_bytes_per_s = 92'160;
    ASSERT_EQ(rig.subscribe(request).refusal, 0);
    rig.ticks(20);
    ASSERT_EQ(rig.command(link::Verb::disarm).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::idle));
    ASSERT_EQ(rig.command(link::Verb::jog, 0, -500'000, 20'000).refusal, 0);
    rig.ticks(400);
    std::size_t moving = 0;
    const std::vector<AxisPositions>& set_points = rig.set_points();
    for (const link::Telemetry& sample : rig.telemetry()) {
        ByteReader reader(std::span(sample.values.data).first(sample.values.size));
        const auto tick = static_cast<std::size_t>(sample.cell_time_us / 1000);
        ASSERT_LT(tick, set_points.size());
        for (std::size_t axis = 0; axis < 4; ++axis) {
            EXPECT_EQ(reader.get<std::int32_t>(), set_points[tick][axis] / kPmPerWireUnit);
        }
        moving += set_points[tick][0] != set_points.front()[0] ? 1U : 0U;
        const auto x = reader.get<std::int32_t>();
        EXPECT_NEAR(static_cast<double>(x), static_cast<double>(set_points[tick][0]) / 1e4, 40'000.0);
        for (std::size_t rest = 0; rest < 3; ++rest) {
            (void)reader.get<std::int32_t>();
        }
        EXPECT_LT(std::abs(reader.get<std::int32_t>()), 5'000) << "the axis follows to 50 um";
    }
    EXPECT_GT(moving, 20U);
    EXPECT_GE(rig.telemetry().size(), 40U);
}

TEST(Clock, HeartbeatsAreAnsweredAlongTheJob) {
    const CellRig& rig = undisturbed();
    ASSERT_GT(rig.clock_replies().size(), 20U);
    for (const link::ClockReply& reply : rig.clock_replies()) {
        EXPECT_GE(reply.sent_us, reply.received_us);
        EXPECT_GE(reply.received_us, reply.host_time_us);
        EXPECT_LE(reply.received_us, reply.host_time_us + 5000) << "the rig's clock is the cell's";
    }
}

TEST(BlackBoxOfTheCell, HoldsHowItCameToTheFault) {
    CellRig::Options options;
    options.script = "pulse 900 estop open\n";
    CellRig rig(options);
    rig.make_ready();
    rig.ticks(6000);
    ASSERT_EQ(rig.open_job(short_job()).refusal, 0);
    ASSERT_EQ(rig.command(link::Verb::start).refusal, 0);
    EXPECT_EQ(rig.black_box(link::BlackboxPart::samples, 0).frozen, 0);
    ASSERT_TRUE(rig.until_state(State::fault, 60'000));
    const auto fault_tick = static_cast<std::uint64_t>(rig.cell().now_ns() / 1'000'000 - 1);
    rig.ticks(2000);
    link::BlackboxChunk head = rig.black_box(link::BlackboxPart::samples, 0);
    EXPECT_EQ(head.frozen, 1);
    EXPECT_EQ(head.fault, static_cast<std::uint8_t>(Fault::estop_open));
    EXPECT_EQ(head.newest_us, fault_tick * 1000);
    EXPECT_GE(head.end - head.begin, 251U);
    const link::BlackboxChunk last = rig.black_box(link::BlackboxPart::samples, head.end - 1);
    ASSERT_EQ(last.count, 1);
    const auto sample = link::unpack_sample(std::span(last.records).first<link::BlackboxSample::kBytes>());
    EXPECT_EQ(sample.tick, fault_tick & 0xFFFFU);
    EXPECT_EQ(sample.state, static_cast<std::uint8_t>(State::fault));
    EXPECT_EQ(sample.flags & link::kFlagEstopClosed, 0);
    // A micrometre is the grain of its places.
    EXPECT_NEAR(sample.actual[0], static_cast<double>(rig.set_points()[fault_tick][0]) * 1e-6, 3000.0);
    const auto& events = rig.black_box(link::BlackboxPart::events, 0);
    const auto newest = rig.black_box(link::BlackboxPart::events, events.end - 2);
    ASSERT_EQ(newest.count, 2);
    const auto fault = link::unpack_event(std::span(newest.records).first<link::BlackboxEvent::kBytes>());
    EXPECT_EQ(fault.kind, static_cast<std::uint8_t>(link::BlackboxKind::fault));
    EXPECT_EQ(fault.b, static_cast<std::uint16_t>(Fault::estop_open));
    EXPECT_EQ(fault.tick, fault_tick);
    const auto state = link::unpack_event(
        std::span(newest.records).subspan(link::BlackboxEvent::kBytes).first<link::BlackboxEvent::kBytes>());
    EXPECT_EQ(state.kind, static_cast<std::uint8_t>(link::BlackboxKind::state));
    EXPECT_EQ(state.a, static_cast<std::uint8_t>(State::fault));
    EXPECT_EQ(state.b, static_cast<std::uint16_t>(State::marking));
}

}  // namespace
