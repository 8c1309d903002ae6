// SPDX-License-Identifier: Apache-2.0
#include "firmware/controller/black_box.hpp"

#include <span>
#include <vector>

#include <gtest/gtest.h>

namespace sc {
namespace {

using link::BlackboxEvent;
using link::BlackboxKind;
using link::BlackboxSample;

constexpr std::int64_t kMs = 1'000'000;

std::vector<BlackboxSample> samples_of(const BlackBox& box) {
    std::vector<BlackboxSample> samples;
    link::BlackboxRequest request{0, 0};
    for (;;) {
        link::BlackboxChunk chunk;
        box.read(request, chunk);
        if (request.first < chunk.begin) {
            request.first = chunk.begin;
            continue;
        }
        for (std::size_t i = 0; i < chunk.count; ++i) {
            samples.push_back(link::unpack_sample(
                std::span(chunk.records).subspan(i * BlackboxSample::kBytes).first<BlackboxSample::kBytes>()));
        }
        request.first += chunk.count;
        if (chunk.count == 0) {
            return samples;
        }
    }
}

/// Runs a box over ticks [from, until).
void run(BlackBox& box, std::int64_t from, std::int64_t until) {
    for (std::int64_t tick = from; tick < until; ++tick) {
        if (box.sample_due(tick)) {
            BlackboxSample sample;
            sample.queue = static_cast<std::uint16_t>(tick / 40 % 60'000);
            box.add(tick, sample);
        }
    }
}

TEST(BlackBox, HoldsTheLastTenSecondsAndTheTickOfTheFault) {
    BlackBox box(kMs);
    run(box, 0, 100'013);
    BlackboxSample last;
    last.queue = 4711;
    box.freeze(100'013, Fault::following_error, 2, last);
    run(box, 100'014, 140'000);
    const auto samples = samples_of(box);
    ASSERT_EQ(samples.size(), BlackBox::kSamples);
    EXPECT_EQ(samples.back().queue, 4711);
    EXPECT_EQ(samples.back().tick, 100'013 & 0xFFFF);
    const auto span = static_cast<std::uint16_t>(samples.back().tick - samples.front().tick);
    EXPECT_GE(span, 10'000);
    for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
        ASSERT_EQ(static_cast<std::uint16_t>(samples[i].tick - samples[i - 1].tick), 40);
    }
    link::BlackboxChunk head;
    box.read({0, 0}, head);
    EXPECT_EQ(head.frozen, 1);
    EXPECT_EQ(head.fault, static_cast<std::uint8_t>(Fault::following_error));
    EXPECT_EQ(head.axis, 2);
    EXPECT_EQ(head.newest_us, 100'013'000U);
    EXPECT_EQ(head.period_ns, 1'000'000U);
}

TEST(BlackBox, ThawsEmpty) {
    BlackBox box(kMs);
    run(box, 0, 1000);
    box.note(7, BlackboxKind::command, 5);
    box.freeze(1000, Fault::estop_open, 0xFF, {});
    box.note(1001, BlackboxKind::command, 6);
    link::BlackboxChunk chunk;
    box.read({1, 0}, chunk);
    EXPECT_EQ(chunk.count, 1);
    box.thaw();
    EXPECT_TRUE(samples_of(box).empty());
    link::BlackboxChunk after;
    box.read({1, 0}, after);
    EXPECT_EQ(after.count, 0);
    EXPECT_EQ(after.frozen, 0);
    run(box, 1001, 2000);
    EXPECT_EQ(samples_of(box).size(), 24U) << "40 ms after the fault's own";
}

TEST(BlackBox, OldEventsGiveWayToNewOnes) {
    BlackBox box(kMs);
    for (std::uint16_t i = 0; i < 1000; ++i) {
        box.note(i, BlackboxKind::request, 0, i);
    }
    link::BlackboxChunk chunk;
    box.read({1, 0}, chunk);
    EXPECT_EQ(chunk.count, 0);
    EXPECT_EQ(chunk.begin, 1000U - BlackBox::kEvents);
    link::BlackboxChunk newest;
    box.read({1, 999}, newest);
    ASSERT_EQ(newest.count, 1);
    const auto event = link::unpack_event(std::span(newest.records).first<BlackboxEvent::kBytes>());
    EXPECT_EQ(event.b, 999);
    EXPECT_EQ(event.tick, 999U);
    link::BlackboxChunk none;
    box.read({2, 0}, none);
    EXPECT_EQ(none.count, 0) << "there is no such part";
    box.read({1, 0xFFFF'FFFF}, none);
    EXPECT_EQ(none.count, 0);
}

}  // namespace
}  // namespace sc
