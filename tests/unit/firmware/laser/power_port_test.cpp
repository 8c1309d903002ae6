// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/power_port.hpp"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sc::laser {
namespace {

constexpr std::int64_t kSetup = 1'250;
constexpr std::int64_t kWidth = 2'500;

PowerPort port() {
    LaserConfig config;
    config.latch_setup_ns = kSetup;
    config.latch_width_ns = kWidth;
    return PowerPort(config);
}

LaserRun run(std::int64_t t0_ns, std::uint16_t count, std::int64_t period_ns, std::uint8_t power) {
    return {t0_ns, period_ns * 256, 0, count, 1, power};
}

TEST(PowerPort, StrobesWhereTheByteChangesAndNowhereElse) {
    PowerPort p = port();
    std::vector<LaserRun> runs{run(100'000, 4, 12'500, 80), run(150'000, 4, 12'500, 80), run(200'000, 4, 12'500, 81)};
    p.step(runs);
    EXPECT_EQ(runs[0].latch_ns, PowerPort::kLeadNs);
    EXPECT_EQ(runs[1].latch_ns, 0);
    EXPECT_EQ(runs[2].latch_ns, 6'250) << "half way from the last trigger at 187.5 us";
    std::vector<LaserRun> next{run(1'000'000, 1, 12'500, 81)};
    p.step(next);
    EXPECT_EQ(next[0].latch_ns, 0) << "kept from tick to tick";
}

TEST(PowerPort, AfterACancelItLatchesAgainAndAfterAClearTheByteIsNought) {
    PowerPort p = port();
    std::vector<LaserRun> runs{run(100'000, 1, 12'500, 80)};
    p.step(runs);
    p.forget();
    runs = {run(200'000, 1, 12'500, 80)};
    p.step(runs);
    EXPECT_GT(runs[0].latch_ns, 0);
    p.cleared();
    runs = {run(300'000, 1, 12'500, 80)};
    p.step(runs);
    EXPECT_GT(runs[0].latch_ns, 0);
}

/// The port as a list of edges, looked at apart from the code that made it.
void check(const std::vector<LaserRun>& runs) {
    std::int64_t busy_until = -1'000'000;
    std::int64_t last_trigger = -1'000'000;
    int byte = 0;
    for (const LaserRun& r : runs) {
        if (r.latch_ns > 0) {
            const std::int64_t rise = r.t0_ns - r.latch_ns;
            ASSERT_GE(rise - kSetup, busy_until) << "lines change while the latch is up";
            ASSERT_GT(rise, last_trigger) << "a pulse of the run before would take it";
            ASSERT_LE(r.latch_ns, PowerPort::kLeadNs);
            busy_until = rise + kWidth;
            byte = r.power;
        }
        ASSERT_EQ(r.power, byte) << "what the run says is what the source has";
        last_trigger = r.t0_ns + (r.count - 1) * r.period_ns256 / 256;
    }
}

TEST(PowerPort, KeepsItsTimesForAnyRunsAtAnyRate) {
    std::mt19937 random(3);
    for (const std::int64_t period : {700, 2'000, 3'000, 5'000, 12'500, 50'000}) {
        PowerPort p = port();
        std::vector<LaserRun> all;
        std::uint32_t changes = 0;
        std::int64_t t = 1'000'000;
        for (int i = 0; i < 2000; ++i) {
            const auto count = static_cast<std::uint16_t>(1 + random() % 16);
            all.push_back(run(t, count, period, static_cast<std::uint8_t>(100 + random() % 3)));
            changes += i > 0 && all[all.size() - 1].power != all[all.size() - 2].power ? 1U : 0U;
            t += count * period + (random() % 5 == 0 ? 40'000 : 0);
        }
        p.step(all);
        check(all);
        if (period >= 5'000) {
            EXPECT_EQ(p.kept(), 0U) << period;
        } else if (period <= 2'000) {
            EXPECT_GT(p.kept(), 0U) << "strobes take 3.75 us";
            EXPECT_LT(p.kept(), changes);
        }
    }
}

}  // namespace
}  // namespace sc::laser
