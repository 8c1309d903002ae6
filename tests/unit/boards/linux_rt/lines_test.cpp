// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/lines.hpp"

#include <utility>

#include <gtest/gtest.h>

namespace sc::linux_rt {
namespace {

constexpr InputBits kBoth = static_cast<InputBits>(bit(Input::estop) | bit(Input::interlock));

class FakePort final : public LinePort {
public:
    [[nodiscard]] InputBits wired() const noexcept override { return kBoth; }
    [[nodiscard]] InputBits levels() noexcept override { return level; }
    void edges(InputBits& down, InputBits& up) noexcept override {
        down = std::exchange(fell, InputBits{0});
        up = std::exchange(rose, InputBits{0});
    }
    void write(OutputBits bits) noexcept override { written = bits; }
    InputBits level = kBoth;
    InputBits fell = 0;
    InputBits rose = 0;
    OutputBits written = 0xFF;
};

TEST(Lines, AnEdgeAndItsLevelAreOneChange) {
    FakePort port;
    Lines lines(port);
    port.level = bit(Input::estop);
    port.fell = bit(Input::interlock);
    const LineSample sample = lines.sample();
    EXPECT_EQ(sample.levels, bit(Input::estop));
    EXPECT_EQ(sample.worst, bit(Input::estop));
    EXPECT_EQ(lines.counters().edges, 1U);
    EXPECT_EQ(lines.counters().missed, 0U);
    EXPECT_EQ(lines.counters().glitches, 0U);
}

TEST(Lines, AMissedEdgeIsCaughtByTheLevel) {
    FakePort port;
    Lines lines(port);
    port.level = bit(Input::estop);  // no event came
    EXPECT_EQ(lines.sample().worst, bit(Input::estop));
    EXPECT_EQ(lines.counters().missed, 1U);
    port.level = kBoth;
    EXPECT_EQ(lines.sample().worst, kBoth);
    EXPECT_EQ(lines.counters().missed, 2U);
}

TEST(Lines, APulseBetweenTwoLooksIsCaughtByItsEdge) {
    FakePort port;
    Lines lines(port);
    port.fell = port.rose = bit(Input::estop);
    const LineSample sample = lines.sample();
    EXPECT_EQ(sample.levels, kBoth);
    EXPECT_EQ(sample.worst, bit(Input::interlock));
    EXPECT_EQ(lines.counters().glitches, 1U);
    EXPECT_EQ(lines.sample().worst, kBoth);
}

TEST(Lines, OutputsGoOutAsBitsAndAreSafeAtTheEnd) {
    FakePort port;
    Lines lines(port);
    DigitalOutputs out;
    out.master_oscillator = true;
    out.light_yellow = true;
    out.shutter_open = true;
    lines.write(out);
    EXPECT_EQ(port.written, bit(Output::master_oscillator) | bit(Output::yellow) | bit(Output::shutter));
    lines.make_safe();
    EXPECT_EQ(port.written, 0);
}

TEST(Lines, BitsStandInTheOrderOfTheControllersInputs) {
    const DigitalInputs in = digital_of(static_cast<InputBits>(bit(Input::interlock) | bit(Input::key_production)));
    EXPECT_TRUE(in.interlock_closed && in.key_production);
    EXPECT_FALSE(in.estop_closed || in.laser_ready || in.key_setup || in.shutter_open);
    EXPECT_TRUE(digital_of(bit(Input::shutter_closed)).shutter_closed);
    EXPECT_TRUE(digital_of(bit(Input::laser_no_alarm)).laser_no_alarm);
}

}  // namespace
}  // namespace sc::linux_rt
