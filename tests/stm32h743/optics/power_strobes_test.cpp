// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/optics/power_strobes.hpp"

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/stm32h743/model/slow_lines.hpp"

namespace sc::stm32h743 {
namespace {

constexpr std::int64_t kSetupNs = 1'000;
constexpr std::int64_t kWidthNs = 2'000;
constexpr std::int64_t kMs = 1'000'000;
constexpr std::uint32_t kLatch = 0x100;

LaserConfig laser() {
    LaserConfig config;
    config.latch_setup_ns = kSetupNs;
    config.latch_width_ns = kWidthNs;
    return config;
}

struct Edge {
    std::int64_t ns = 0;
    std::uint32_t levels = 0;
};

struct Rig {
    Rig() {
        machine.attach(model::ClockGates::kBase, 0x400, clocks);
        machine.attach(model::DmaModel::kBase2, 0x400, dma);
        machine.attach(model::DmaModel::kMuxBase2, 0x20, dma.mux);
        machine.map_memory(0x30020000, std::span(reinterpret_cast<std::uint8_t*>(buffers.get()), sizeof *buffers));
        port.on_change = [this](std::int64_t ns, std::uint32_t levels) { edges.push_back({ns - zero, levels}); };
        machine.advance_to(1'000);
        EXPECT_TRUE(clock.start(-kMs));
        zero = tim5.started_ns() + kMs;
        EXPECT_TRUE(strobes.start(kMs));
    }
    /// Tick n at its time, 300 us long: the strobes of window n + 1.
    [[nodiscard]] bool tick(const std::vector<LaserRun>& runs, bool clear = false) {
        machine.advance_to(zero + next * kMs + 300'000);
        ++next;
        return strobes.fill(runs, clear);
    }
    void pass(int ticks) {
        for (int i = 0; i < ticks; ++i) {
            ASSERT_TRUE(tick({}));
        }
    }
    [[nodiscard]] LaserRun run(std::int64_t after_ns, std::uint8_t power, std::uint16_t latch_ns) const {
        LaserRun made;
        made.t0_ns = (next + 1) * kMs + after_ns;
        made.power = power;
        made.latch_ns = latch_ns;
        made.count = 1;
        return made;
    }
    void expect_strobe(std::int64_t rise_ns, std::uint32_t byte) {
        expected.push_back({rise_ns - kSetupNs, byte});
        expected.push_back({rise_ns, byte | kLatch});
        expected.push_back({rise_ns + kWidthNs, byte});
    }
    /// A byte that is on the lines already makes no edge.
    void expect_edges() {
        std::vector<Edge> want;
        std::uint32_t levels = 0;
        for (const Edge& edge : expected) {
            if (edge.levels != levels) {
                want.push_back(edge);
            }
            levels = edge.levels;
        }
        ASSERT_EQ(edges.size(), want.size());
        for (std::size_t i = 0; i < want.size(); ++i) {
            EXPECT_EQ(edges[i].levels, want[i].levels) << i;
            EXPECT_NEAR(static_cast<double>(edges[i].ns), static_cast<double>(want[i].ns), 6.0) << i;
        }
    }

    model::Machine machine;
    model::ClockGates clocks{machine};
    model::DmaModel dma{machine, clocks, model::DmaModel::Which::second};
    model::SlowPort port{machine, clocks, 5};
    model::Counter tim5{machine, clocks, &dma};
    std::unique_ptr<PowerBuffers> buffers = std::make_unique<PowerBuffers>();
    ControlClock clock;
    PowerStrobes strobes{*buffers, clock, laser()};
    std::int64_t zero = 0;
    std::int64_t next = 0;
    std::vector<Edge> edges;
    std::vector<Edge> expected;
};

class PowerStrobesTest : public testing::Test, protected Rig {
protected:
    void TearDown() override { EXPECT_EQ(machine.violations_text(), ""); }
};

TEST_F(PowerStrobesTest, AStrobeLeavesBeforeItsRun) {
    pass(3);
    const LaserRun one = run(200'000, 0xA5, 5'000);
    expect_strobe(one.t0_ns - 5'000, 0xA5);
    ASSERT_TRUE(tick({one}));
    pass(3);
    expect_edges();
}

TEST_F(PowerStrobesTest, AStrobeMayBeginInTheWindowBefore) {
    const LaserRun one = run(0, 0x40, 10'000);
    expect_strobe(one.t0_ns - 10'000, 0x40);
    ASSERT_TRUE(tick({one}));
    pass(2);
    expect_edges();
}

TEST_F(PowerStrobesTest, RunsThatKeepTheByteHaveNone) {
    ASSERT_TRUE(tick({run(100'000, 0x40, 5'000), run(200'000, 0x40, 0), run(300'000, 0x40, 0)}));
    pass(2);
    EXPECT_EQ(edges.size(), 3U);
}

/// Windows with up to 60 strobes, over many laps of the ring and more than one of the counter.
TEST_F(PowerStrobesTest, EveryStrobeOfRandomWindowsLeavesAtItsTime) {
    std::mt19937 random(5);
    const auto within = [&random](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
    std::int64_t free = 0;
    for (int n = 0; n < 20'000; ++n) {
        std::vector<LaserRun> runs;
        const int most = n % 500 < 40 ? within(0, 60) : 0;
        std::int64_t at = std::max<std::int64_t>(free, (next + 1) * kMs) + within(0, 200'000);
        for (int i = 0; i < most && at < (next + 2) * kMs - 3'000; ++i) {
            LaserRun one;
            one.t0_ns = at;
            one.power = static_cast<std::uint8_t>(within(0, 255));
            one.latch_ns = static_cast<std::uint16_t>(within(2'000, 10'000));
            one.count = 1;
            runs.push_back(one);
            expect_strobe(one.t0_ns - one.latch_ns, one.power);
            at += 10'000 + kSetupNs + kWidthNs + 600 + within(0, within(0, 1) == 0 ? 100 : 30'000);
        }
        free = at;
        ASSERT_TRUE(tick(runs)) << n;
    }
    pass(2);
    expect_edges();
    EXPECT_EQ(strobes.refused(), 0U);
}

TEST_F(PowerStrobesTest, TheByteIsClearedOnce) {
    expect_strobe((next + 1) * kMs + kSetupNs, 0);
    ASSERT_TRUE(tick({}, true));
    ASSERT_TRUE(tick({}, true));
    ASSERT_TRUE(tick({}, true));
    expect_strobe((next + 1) * kMs + 500'000, 0x80);
    ASSERT_TRUE(tick({run(505'000, 0x80, 5'000)}));
    expect_strobe((next + 1) * kMs + kSetupNs, 0);
    ASSERT_TRUE(tick({}, true));
    ASSERT_TRUE(tick({}, true));
    pass(2);
    expect_edges();
}

TEST_F(PowerStrobesTest, StrobesThatOverlapAreRefusedAndNothingFollows) {
    ASSERT_FALSE(tick({run(100'000, 0x10, 5'000), run(103'000, 0x20, 5'000)}));
    ASSERT_FALSE(tick({}));
    ASSERT_FALSE(tick({run(100'000, 0x30, 5'000)}));
    EXPECT_EQ(strobes.refused(), 3U);
    edges.clear();
    machine.advance_to(machine.now_ns() + 5 * kMs);
    EXPECT_TRUE(edges.empty());
    EXPECT_EQ(port.levels() & kLatch, 0U);
}

TEST_F(PowerStrobesTest, ALateWindowIsRefused) {
    pass(2);
    machine.advance_to(zero + next * kMs + 900'000);
    EXPECT_FALSE(strobes.fill({}, false));
}

/// Whenever the processor comes, the strobe leaves at its time or is refused.
TEST(PowerStrobesLate, NoFillLeavesAWrongEdge) {
    int filled = 0;
    int refused = 0;
    for (std::int64_t delay = 500'000; delay < 1'000'000; delay += 1'370) {
        Rig rig;
        rig.pass(2);
        rig.machine.advance_to(rig.zero + rig.next * kMs + delay);
        ++rig.next;
        LaserRun one;
        one.t0_ns = rig.next * kMs + 100'000;
        one.power = 0x5A;
        one.latch_ns = 5'000;
        one.count = 1;
        if (rig.strobes.fill({&one, 1}, false)) {
            ++filled;
            rig.expect_strobe(one.t0_ns - 5'000, 0x5A);
        } else {
            ++refused;
        }
        rig.machine.advance_to(rig.zero + rig.next * kMs + 600'000);
        rig.expect_edges();
        EXPECT_EQ(rig.machine.violations_text(), "") << delay;
    }
    EXPECT_GT(filled, 100);
    EXPECT_GT(refused, 20);
}

TEST_F(PowerStrobesTest, ACancelledClearIsMadeAgain) {
    ASSERT_TRUE(tick({run(100'000, 0x22, 5'000)}));
    ASSERT_TRUE(tick({}, true));
    machine.advance_to(zero + next * kMs - 100'000);
    strobes.cancel();
    edges.clear();
    expected.clear();
    machine.advance_to(zero + next * kMs + 300'000);
    ASSERT_TRUE(tick({}));
    expect_strobe((next + 1) * kMs + kSetupNs, 0);
    ASSERT_TRUE(tick({}, true));
    pass(2);
    ASSERT_EQ(edges.size(), 3U);
    EXPECT_EQ(port.levels(), 0U);
}

TEST_F(PowerStrobesTest, CancelAfterLapsOfTheRing) {
    pass(400);
    strobes.cancel();
    pass(2);
    expect_strobe((next + 1) * kMs + 95'000, 0x42);
    ASSERT_TRUE(tick({run(100'000, 0x42, 5'000)}));
    pass(2);
    expect_edges();
}

TEST_F(PowerStrobesTest, ALostWindowIsRefused) {
    pass(2);
    machine.advance_to(zero + (next + 3) * kMs);
    EXPECT_FALSE(strobes.fill({}, false));
    strobes.cancel();
    EXPECT_EQ(strobes.refused(), 1U);
}

TEST_F(PowerStrobesTest, CancelDropsWhatWaitsAndTheNextByteIsStrobedAgain) {
    const LaserRun early = run(100'000, 0x11, 5'000);
    expect_strobe(early.t0_ns - 5'000, 0x11);
    ASSERT_TRUE(tick({early, run(800'000, 0x22, 5'000)}));
    machine.advance_to(zero + next * kMs + 300'000);
    strobes.cancel();
    ++next;
    ASSERT_TRUE(strobes.fill({}, true));
    expect_strobe(next * kMs + kSetupNs, 0);
    expect_strobe((next + 1) * kMs + 395'000, 0x33);
    ASSERT_TRUE(tick({run(400'000, 0x33, 5'000)}));
    pass(3);
    expect_edges();
}

TEST_F(PowerStrobesTest, CancelInAStrobeLetsTheLatchFall) {
    const LaserRun one = run(100'000, 0x11, 5'000);
    ASSERT_TRUE(tick({one}));
    machine.advance_to(zero + one.t0_ns - 4'500);
    ASSERT_NE(port.levels() & kLatch, 0U);
    strobes.cancel();
    EXPECT_EQ(port.levels(), 0x11U);
    edges.clear();
    machine.advance_to(machine.now_ns() + 100'000);
    EXPECT_TRUE(edges.empty());
}

TEST_F(PowerStrobesTest, StartsWithTheLinesLow) {
    ASSERT_TRUE(tick({run(100'000, 0xFF, 5'000)}));
    pass(2);
    ASSERT_EQ(port.levels(), 0xFFU);
    ASSERT_TRUE(strobes.start((next + 1) * kMs));
    EXPECT_EQ(port.levels(), 0U);
    pass(2);
}

}  // namespace
}  // namespace sc::stm32h743
