// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/pacer.hpp"

#include <gtest/gtest.h>

namespace sc::linux_rt {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// Wakes so late as it is told.
class FakeClock final : public Clock {
public:
    [[nodiscard]] std::int64_t now_ns() noexcept override { return now; }
    void sleep_until(std::int64_t ns) noexcept override { now = (ns > now ? ns : now) + late; }
    std::int64_t now = 5'000'000'000;
    std::int64_t late = 0;
};

TEST(Pacer, KeepsAbsoluteTimesWhateverTheWorkTakes) {
    FakeClock clock;
    Pacer pacer(clock, kMs);
    pacer.begin();
    for (int i = 1; i <= 100; ++i) {
        clock.late = i % 7 * 10'000;
        pacer.wait();
        EXPECT_EQ(clock.now, 5'000'000'000 + i * kMs + clock.late);
        clock.now += 300'000;
        pacer.done();
    }
    EXPECT_EQ(pacer.overruns(), 0U);
    EXPECT_EQ(pacer.late().count(), 100U);
    EXPECT_EQ(pacer.late().max_ns(), 60'000);
    EXPECT_EQ(pacer.work().max_ns(), 300'000);
    EXPECT_EQ(pacer.work().quantile_us(0.5), 300U);
}

TEST(Pacer, CountsOverrunsAndGoesOnFromThere) {
    FakeClock clock;
    Pacer pacer(clock, kMs);
    pacer.begin();
    pacer.wait();
    clock.now += 5 * kMs;  // work that takes far too long
    pacer.done();
    pacer.wait();
    EXPECT_EQ(pacer.overruns(), 1U);
    EXPECT_EQ(pacer.overruns_in_a_row(), 1U);
    const std::int64_t late = clock.now;
    pacer.wait();
    EXPECT_EQ(clock.now, late + kMs);
    EXPECT_EQ(pacer.overruns(), 1U);
    EXPECT_EQ(pacer.overruns_in_a_row(), 0U);
}

TEST(Pacer, WorkLongerThanThePeriodButWithinTwoIsLateAndCatchesUp) {
    FakeClock clock;
    Pacer pacer(clock, kMs);
    pacer.begin();
    pacer.wait();
    clock.now += kMs + 400'000;
    pacer.wait();
    EXPECT_EQ(pacer.overruns(), 0U);
    EXPECT_EQ(pacer.late().max_ns(), 400'000);
    pacer.wait();
    EXPECT_EQ(clock.now, 5'000'000'000 + 3 * kMs);
}

TEST(Histogram, HasEachMicrosecondAndWhatIsBeyond) {
    Histogram h;
    EXPECT_EQ(h.mean_us(), 0.0);
    for (int us = 0; us < 100; ++us) {
        h.add(us * 1000 + 500);
    }
    h.add(7 * kMs);
    EXPECT_EQ(h.count(), 101U);
    EXPECT_EQ(h.at(0), 1U);
    EXPECT_EQ(h.at(99), 1U);
    EXPECT_EQ(h.at(Histogram::kBuckets), 1U);
    EXPECT_EQ(h.max_ns(), 7 * kMs);
    EXPECT_EQ(h.quantile_us(0.5), 50U);
    EXPECT_EQ(h.quantile_us(1.0), Histogram::kBuckets);
    EXPECT_NEAR(h.mean_us(), (100 * 50.0 + 7000.0) / 101.0, 1e-9);
}

TEST(SystemClock, SleepsToAnAbsoluteTime) {
    SystemClock clock;
    const std::int64_t until = clock.now_ns() + 2 * kMs;
    clock.sleep_until(until);
    EXPECT_GE(clock.now_ns(), until);
    clock.sleep_until(until);  // past: at once
}

}  // namespace
}  // namespace sc::linux_rt
