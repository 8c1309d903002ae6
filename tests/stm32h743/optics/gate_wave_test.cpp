// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/optics/gate_wave.hpp"

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/stm32h743/model/advanced_timer.hpp"
#include "tests/stm32h743/optics/pulse_reference.hpp"

namespace sc::stm32h743 {
namespace {

using test::expected_pulses;
using test::Pulse;

class GateWaveTest : public ::testing::Test {
protected:
    GateWaveTest() {
        machine.attach(model::ClockGates::kBase, 0x400, clocks);
        machine.attach(model::EdgePort::kBase, 0x400, port);
        machine.attach(model::DmaModel::kBase2, 0x400, dma);
        machine.attach(model::DmaModel::kMuxBase2, 0x20, dma.mux);
        machine.attach(model::AdvancedTimer::kBase, 0x400, timer);
        machine.map_memory(0x30020000, std::span(reinterpret_cast<std::uint8_t*>(buffers.get()), sizeof *buffers));
        timer.set_break_pin(true);
        // What was in the memory before must not matter.
        std::ranges::fill(buffers->ring, Segment{200, 0, kNoCount, kNoCount, 48});
    }
    ~GateWaveTest() override { EXPECT_EQ(machine.violations_text(), ""); }

    void start() {
        machine.advance_to(machine.now_ns() + 12'345);
        ASSERT_TRUE(wave.start(0));
        window = 0;
    }
    void control_time(std::int64_t ns) {
        while (machine.now_ns() < timer.started_ns() + ns) {
            machine.advance_to(std::min(machine.now_ns() + 100'000, timer.started_ns() + ns));
            if (guarded) {
                (void)wave.check();
            }
        }
    }
    /// A tick: the runs of the next window, 300 µs behind the beginning of this one.
    void tick(const std::vector<LaserRun>& runs) {
        control_time(window * kWindowNs + 300'000);
        ++window;
        ASSERT_TRUE(wave.fill(runs));
        all.insert(all.end(), runs.begin(), runs.end());
    }
    /// Triggers on the pins, with the gate as it stands there; the gate must not move near them.
    std::vector<Pulse> seen() const {
        std::vector<Pulse> pulses;
        model::AdvancedTimer::Level before;
        std::int64_t gate_moved = -1'000;
        std::int64_t rose = -1'000;
        for (const auto& level : timer.levels) {
            if (level.trigger && !before.trigger) {
                pulses.push_back({level.count, level.gate});
                EXPECT_GE(level.count - gate_moved, 60);
                rose = level.count;
            } else if (!level.trigger && before.trigger && !cut) {
                EXPECT_EQ(level.count - rose, 48);
            }
            if (level.gate != before.gate) {
                gate_moved = level.count;
                if (!cut) {
                    EXPECT_GE(level.count - rose, 60);
                }
            }
            before = level;
        }
        return pulses;
    }
    void compare(const std::vector<Pulse>& wanted) const {
        const std::vector<Pulse> pulses = seen();
        ASSERT_EQ(pulses.size(), wanted.size());
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            ASSERT_EQ(pulses[i].count, wanted[i].count) << "trigger " << i;
            ASSERT_EQ(pulses[i].picked, wanted[i].picked) << "trigger " << i;
        }
    }
    static LaserRun run(std::int64_t t0_ns, std::int64_t period_ns, std::uint16_t count) {
        LaserRun one;
        one.t0_ns = t0_ns;
        one.period_ns256 = period_ns * 256;
        one.count = count;
        return one;
    }

    model::Machine machine;
    model::ClockGates clocks{machine};
    model::EdgePort port{machine, clocks};
    model::DmaModel dma{machine, clocks, model::DmaModel::Which::second};
    model::AdvancedTimer timer{machine, clocks, dma, port};
    std::unique_ptr<GateBuffers> buffers = std::make_unique<GateBuffers>();
    GateWave wave{*buffers};
    std::vector<LaserRun> all;
    std::int64_t window = 0;
    bool guarded = true;
    bool cut = false;  ///< outputs may end in a pulse
};

TEST_F(GateWaveTest, TriggersLeaveAtTheirCountsThroughManyWindows) {
    std::mt19937 random{7};
    std::int64_t last = 0;
    start();
    ASSERT_TRUE(wave.arm());
    for (std::int64_t n = 1; n <= 150; ++n) {
        tick(test::random_window(random, n * kWindowNs, last));
    }
    tick({});
    control_time(151 * kWindowNs);
    compare(expected_pulses(all));
    EXPECT_GT(timer.levels.size(), 20'000U);
    EXPECT_EQ(wave.refused() + wave.failures(), 0U);
}

TEST_F(GateWaveTest, KeepsUpWithTheFastestSource) {
    start();
    ASSERT_TRUE(wave.arm());
    for (std::int64_t n = 1; n <= 12; ++n) {
        LaserRun fast = run(n * kWindowNs, 0, 300);
        fast.pick = 5;
        fast.period_ns256 = 853'333;  // five triggers of 666.7 ns
        tick({fast});
    }
    tick({});
    control_time(13 * kWindowNs);
    compare(expected_pulses(all));
    EXPECT_EQ(wave.refused() + wave.failures(), 0U);
}

TEST_F(GateWaveTest, NothingLeavesUntilItIsArmed) {
    start();
    tick({run(1'000'000, 10'000, 50)});
    EXPECT_FALSE(wave.check());
    control_time(1'900'000);
    EXPECT_TRUE(timer.levels.empty());
}

TEST_F(GateWaveTest, TheBreakInputActsAtOnceAndForGood) {
    start();
    ASSERT_TRUE(wave.arm());
    tick({run(1'000'000, 2'000, 480)});
    tick({run(2'000'000, 2'000, 480)});
    control_time(1'500'100);  // within a pulse
    EXPECT_TRUE(timer.levels.back().trigger);
    timer.set_break_pin(false);
    cut = true;
    const std::size_t before = seen().size();
    EXPECT_FALSE(timer.levels.back().trigger);
    EXPECT_FALSE(timer.levels.back().gate);
    EXPECT_TRUE(wave.broken());
    EXPECT_FALSE(wave.check());
    EXPECT_FALSE(wave.arm());
    control_time(1'700'000);
    timer.set_break_pin(true);
    control_time(2'100'000);
    EXPECT_EQ(seen().size(), before);
    EXPECT_TRUE(wave.broken());
    control_time(2'300'901);
    ASSERT_TRUE(wave.arm());
    EXPECT_FALSE(wave.broken());
    tick({});
    control_time(3'500'000);
    const std::vector<Pulse> pulses = seen();
    ASSERT_GT(pulses.size(), before);
    EXPECT_EQ(pulses.back().count, (2'000'000 + 479 * 2'000) * 6 / 25);  // in step, as if nothing had been
}

TEST_F(GateWaveTest, AFloatingBreakInputIsABreak) {
    timer.set_break_pin(false);
    start();
    EXPECT_TRUE(port.pulled_down(15));
    EXPECT_FALSE(wave.arm());
}

TEST_F(GateWaveTest, WhatIsCancelledNeverLeavesAndTheRestStaysInStep) {
    for (const std::int64_t at : {1'100'000, 1'350'500, 1'899'000, 1'905'000}) {
        start();
        all.clear();
        ASSERT_TRUE(wave.arm());
        tick({run(1'000'000, 1'000, 999)});
        if (at > 1'300'000) {
            tick({run(2'000'000, 1'000, 999)});
        }
        control_time(at);
        cut = true;
        wave.cancel();
        const std::size_t before = seen().size();
        EXPECT_FALSE(wave.arm());  // what is loaded already would leave
        if (at < 1'300'000) {
            tick({});
        }
        tick({run(3'000'003, 3'333, 200)});
        ASSERT_TRUE(wave.arm());
        tick({});
        control_time(4'000'000);
        const std::vector<Pulse> pulses = seen();
        const std::vector<Pulse> wanted = expected_pulses({run(3'000'003, 3'333, 200)});
        ASSERT_EQ(pulses.size(), before + wanted.size()) << at;
        EXPECT_EQ(pulses.at(before).count, wanted.front().count) << at;
        EXPECT_EQ(pulses.back().count, wanted.back().count) << at;
    }
}

TEST_F(GateWaveTest, ArmRightBehindACancelNeverLetsOldPulsesOut) {
    start();
    ASSERT_TRUE(wave.arm());
    tick({run(1'000'000, 10'000, 90)});
    control_time(1'503'000);
    wave.cancel();
    cut = true;
    const std::size_t before = seen().size();
    bool armed = false;
    for (std::int64_t t = 1'503'500; t < 1'700'000; t += 500) {
        control_time(t);
        armed = wave.arm() || armed;
    }
    EXPECT_TRUE(armed);
    EXPECT_EQ(seen().size(), before);
}

TEST_F(GateWaveTest, WithoutATickItGoesDarkAndSaysSo) {
    start();
    ASSERT_TRUE(wave.arm());
    tick({run(1'000'000, 1'000, 999)});
    const std::vector<Pulse> wanted = expected_pulses(all);
    guarded = false;
    control_time(12'000'000);
    EXPECT_FALSE(wave.check());
    EXPECT_FALSE(wave.arm());
    EXPECT_FALSE(wave.fill({}));
    EXPECT_EQ(wave.failures(), 1U);
    // The last triggers wait for their neighbours, which did not come.
    const std::vector<Pulse> pulses = seen();
    ASSERT_GE(pulses.size(), 899U);
    ASSERT_LE(pulses.size(), 902U);
    EXPECT_EQ(pulses.back().count, wanted.at(pulses.size() - 1).count);
    EXPECT_LE(timer.levels.back().count, pulses.back().count + kGateCounts);  // not even the gate
    start();
    all.clear();
    guarded = true;
    ASSERT_TRUE(wave.arm());
    tick({run(1'000'000, 1'000, 500)});
    tick({});
    control_time(2'000'000);
    compare(expected_pulses(all));
}

TEST_F(GateWaveTest, TheDeadlineIsEnough) {
    start();
    ASSERT_TRUE(wave.arm());
    for (std::int64_t n = 1; n <= 8; ++n) {
        control_time(n * kWindowNs - GateWave::kDeadlineNs);
        const LaserRun one = run(n * kWindowNs + 1'234, 25'000, 30);
        ASSERT_TRUE(wave.fill(std::span(&one, 1)));
        all.push_back(one);
    }
    control_time(9 * kWindowNs - GateWave::kDeadlineNs);
    ASSERT_TRUE(wave.fill({}));
    control_time(9 * kWindowNs);
    compare(expected_pulses(all));
}

TEST_F(GateWaveTest, WhatComesTooLateNeverPlays) {
    for (std::int64_t late = 1'690'000; late < 1'960'000; late += 1'370) {
        start();
        guarded = false;
        ASSERT_TRUE(wave.arm());
        tick({});
        control_time(late);
        const LaserRun one = run(2'000'000, 10'000, 50);
        const bool filled = wave.fill(std::span(&one, 1));
        control_time(2'600'000);
        const std::size_t pulses = seen().size();
        EXPECT_EQ(pulses, filled ? 50U : 0U) << late;
        EXPECT_TRUE(filled || late > 1'750'000) << late;
        EXPECT_TRUE(!filled || late < 1'860'000) << late;
        EXPECT_EQ(wave.check(), filled);
    }
}

TEST_F(GateWaveTest, ShutAndArmedAgainItIsInStep) {
    start();
    ASSERT_TRUE(wave.arm());
    tick({run(1'000'000, 10'000, 99)});
    control_time(1'253'000);
    wave.shut();
    EXPECT_FALSE(wave.check());
    control_time(1'453'000);
    EXPECT_EQ(seen().size(), 26U);
    ASSERT_TRUE(wave.arm());
    EXPECT_TRUE(wave.check());
    control_time(1'600'000);
    const std::vector<Pulse> pulses = seen();
    ASSERT_GT(pulses.size(), 26U);
    EXPECT_EQ(pulses.at(26).count, 1'460'000 * 6 / 25);
}

}  // namespace
}  // namespace sc::stm32h743
