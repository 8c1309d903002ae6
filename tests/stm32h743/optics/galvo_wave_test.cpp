// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/optics/galvo_wave.hpp"

#include <algorithm>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "tests/stm32h743/model/optics.hpp"

namespace sc::stm32h743 {
namespace {

using Frames = std::array<GalvoFrame, kGalvoFramesPerTick>;
constexpr std::uint32_t kStartX = 0x30000;
constexpr std::uint32_t kStartZ = 0x2FFFE;

struct WireFrame {
    std::int64_t ns = 0;  ///< first rising clock
    std::uint32_t x = 0;
    std::uint32_t z = 0;
    bool operator==(const WireFrame&) const = default;
};

/// What a head sees: bits at the falling clock, a frame ends with the bit whose sync is low. Notes everything that a
/// head does not like.
std::vector<WireFrame> decode(const std::vector<model::EdgePort::Edge>& edges, std::vector<std::string>& faults) {
    std::vector<WireFrame> frames;
    WireFrame frame;
    unsigned bits = 0;
    std::int64_t last = 0;
    for (const auto& edge : edges) {
        const std::uint32_t changed = edge.before ^ edge.after;
        const bool clock = (edge.after & 4U) != 0;
        if ((changed & 4U) == 0) {
            faults.push_back("a line changes without the clock at " + std::to_string(edge.ns));
        }
        if (!clock && changed != 4U) {
            faults.push_back("a line changes while it is sampled at " + std::to_string(edge.ns));
        }
        if (last != 0 && edge.ns - last != 250) {
            faults.push_back("clock of " + std::to_string(edge.ns - last) + " ns at " + std::to_string(edge.ns));
        }
        last = edge.ns;
        if (clock) {
            frame.ns = bits == 0 ? edge.ns : frame.ns;
            continue;
        }
        frame.x = (frame.x << 1U) | ((edge.after >> 4U) & 1U);
        frame.z = (frame.z << 1U) | ((edge.after >> 5U) & 1U);
        ++bits;
        if ((edge.after & 8U) == 0) {
            if (bits != 20) {
                faults.push_back("a frame of " + std::to_string(bits) + " bits at " + std::to_string(edge.ns));
            }
            frames.push_back(frame);
            frame = {};
            bits = 0;
        }
    }
    return frames;
}

class GalvoWaveTest : public ::testing::Test {
protected:
    GalvoWaveTest() {
        machine.attach(model::ClockGates::kBase, 0x400, clocks);
        machine.attach(model::EdgePort::kBase, 0x400, port);
        machine.attach(model::DmaModel::kBase, 0x400, dma);
        machine.attach(model::DmaModel::kMuxBase, 0x20, dma.mux);
        machine.attach(model::BasicTimer::kBase, 0x400, timer);
        machine.map_memory(0x30000000, std::span(reinterpret_cast<std::uint8_t*>(buffers.get()), sizeof *buffers));
        machine.on_interrupt(11, [this] {
            play_ok = wave.swapped();
            swap_ns.push_back(machine.now_ns());
            if (fills) {
                next();
            }
        });
    }
    ~GalvoWaveTest() override { EXPECT_EQ(machine.violations_text(), ""); }

    void next() {
        Frames frames{};
        for (GalvoFrame& frame : frames) {
            frame.word_x = random() & 0xFFFFFU;
            frame.word_z = random() & 0xFFFFFU;
        }
        ASSERT_TRUE(wave.fill(frames));
        for (const GalvoFrame& frame : frames) {
            sent.push_back({0, frame.word_x, frame.word_z});
        }
    }
    /// With the guard each 100 µs.
    void run_to(std::int64_t ns) {
        while (machine.now_ns() < ns) {
            machine.advance_to(std::min(machine.now_ns() + 100'000, ns));
            if (guarded) {
                gate_may_open = wave.check();
            }
        }
    }
    /// Frames on the wire, which must be without fault, 10 µs apart from the first on.
    std::vector<WireFrame> seen() {
        std::vector<std::string> faults;
        std::vector<WireFrame> frames = decode(port.edges, faults);
        EXPECT_TRUE(faults.empty()) << faults.size() << ", " << faults.front();
        for (std::size_t i = 0; i < frames.size(); ++i) {
            EXPECT_EQ(frames[i].ns, timer.started_ns + 250 + static_cast<std::int64_t>(i) * 10'000);
            frames[i].ns = 0;
        }
        return frames;
    }

    model::Machine machine;
    model::ClockGates clocks{machine};
    model::EdgePort port{machine, clocks};
    model::DmaModel dma{machine, clocks};
    model::BasicTimer timer{machine, clocks, dma};
    std::unique_ptr<GalvoBuffers> buffers = std::make_unique<GalvoBuffers>();
    GalvoWave wave{*buffers};
    std::mt19937 random{11};
    std::vector<WireFrame> sent = std::vector<WireFrame>(100, {0, kStartX, kStartZ});
    std::vector<std::int64_t> swap_ns;
    bool fills = true;
    bool guarded = true;
    bool play_ok = true;
    bool gate_may_open = false;
};

TEST_F(GalvoWaveTest, FramesOnTheWireAreThoseGivenBitForBit) {
    ASSERT_TRUE(wave.start(kStartX, kStartZ));
    next();
    run_to(40'100'000);
    const std::vector<WireFrame> frames = seen();
    ASSERT_EQ(frames.size(), 4009U);  // 100 a millisecond, from a start within the first one's frame
    ASSERT_GE(sent.size(), frames.size());
    EXPECT_TRUE(std::equal(frames.begin(), frames.end(), sent.begin()));
    ASSERT_EQ(swap_ns.size(), 40U);
    EXPECT_EQ(swap_ns.back() - swap_ns.front(), 39'000'000);
    EXPECT_EQ(wave.underruns() + wave.errors(), 0U);
    EXPECT_TRUE(gate_may_open);
    EXPECT_TRUE(play_ok);
}

TEST_F(GalvoWaveTest, RepeatsTheLastFrameWithTheGateShutWhenItIsNotFilled) {
    ASSERT_TRUE(wave.start(kStartX, kStartZ));
    EXPECT_FALSE(wave.check());
    next();
    run_to(3'500'000);
    EXPECT_TRUE(gate_may_open);
    fills = false;  // the window from 5 ms on has no frames
    run_to(4'700'000);
    EXPECT_TRUE(gate_may_open);
    run_to(4'950'000);
    EXPECT_FALSE(gate_may_open);  // before the swap
    Frames late{};
    EXPECT_FALSE(wave.fill(late));
    EXPECT_EQ(wave.underruns(), 1U);
    run_to(5'500'000);
    EXPECT_TRUE(play_ok);
    fills = true;
    sent.insert(sent.end(), 200, sent.back());
    run_to(6'500'000);
    EXPECT_FALSE(gate_may_open);
    run_to(9'000'000);
    EXPECT_TRUE(gate_may_open);
    EXPECT_EQ(wave.underruns(), 2U);
    const std::vector<WireFrame> frames = seen();
    ASSERT_GE(sent.size(), frames.size());
    EXPECT_TRUE(std::equal(frames.begin(), frames.end(), sent.begin()));
}

TEST_F(GalvoWaveTest, SaysThatNobodyCheckedTheSwap) {
    ASSERT_TRUE(wave.start(kStartX, kStartZ));
    fills = false;
    guarded = false;
    run_to(1'500'000);
    EXPECT_FALSE(play_ok);
    EXPECT_EQ(wave.underruns(), 1U);
    EXPECT_FALSE(wave.check());
    (void)seen();
}

TEST_F(GalvoWaveTest, TakesOneWindowOfFramesATick) {
    ASSERT_TRUE(wave.start(kStartX, kStartZ));
    next();
    Frames again{};
    EXPECT_FALSE(wave.fill(again));
    run_to(2'500'000);
    const std::vector<WireFrame> frames = seen();
    EXPECT_TRUE(std::equal(frames.begin(), frames.end(), sent.begin()));
}

TEST_F(GalvoWaveTest, StartsAgainFromAnyState) {
    ASSERT_TRUE(wave.start(kStartX, kStartZ));
    next();
    run_to(1'734'567);  // the flag of half a buffer stands
    ASSERT_TRUE(wave.start(kStartX, kStartZ));
    port.edges.clear();
    sent.assign(100, {0, kStartX, kStartZ});
    next();
    run_to(4'000'000);
    const std::vector<WireFrame> frames = seen();
    EXPECT_TRUE(std::equal(frames.begin(), frames.end(), sent.begin()));
    EXPECT_EQ(wave.errors(), 0U);
}

}  // namespace
}  // namespace sc::stm32h743
