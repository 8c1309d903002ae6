// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/io/digital_port.hpp"

#include <gtest/gtest.h>

#include "tests/stm32h743/model/slow_lines.hpp"

namespace sc::stm32h743 {
namespace {

class DigitalPortTest : public testing::Test {
protected:
    DigitalPortTest() { machine.attach(model::ClockGates::kBase, 0x400, clocks); }
    void TearDown() override { EXPECT_EQ(machine.violations_text(), ""); }
    [[nodiscard]] static DigitalInputs sampled() {
        DigitalInputs in;
        DigitalPort::sample(in);
        return in;
    }

    model::Machine machine;
    model::ClockGates clocks{machine};
    model::SlowPort d{machine, clocks, 3};
    model::SlowPort f{machine, clocks, 5};
    model::SlowPort g{machine, clocks, 6};
};

TEST_F(DigitalPortTest, EachInputHasItsPin) {
    ASSERT_TRUE(DigitalPort::start());
    constexpr std::array<bool DigitalInputs::*, 6> kInputs{
        &DigitalInputs::laser_ready,    &DigitalInputs::laser_no_alarm, &DigitalInputs::shutter_open,
        &DigitalInputs::shutter_closed, &DigitalInputs::key_setup,      &DigitalInputs::key_production};
    g.drive(0xF, 0);
    for (unsigned pin = 0; pin < kInputs.size(); ++pin) {
        d.drive(0xFC00, 1U << (10 + pin));
        DigitalInputs one;
        one.*kInputs.at(pin) = true;
        EXPECT_EQ(sampled(), one) << pin;
    }
    d.drive(0xFC00, 0);
    for (unsigned status = 0; status < 16; ++status) {
        g.drive(0xF, status);
        EXPECT_EQ(sampled().source_status, status);
    }
}

TEST_F(DigitalPortTest, ABrokenWireReadsAsTheFault) {
    d.drive(0xFC00, 0xFC00);
    g.drive(0xF, 0xF);
    ASSERT_TRUE(DigitalPort::start());
    d.release(0xFC00);
    g.release(0xF);
    EXPECT_EQ(sampled(), DigitalInputs{});
}

TEST_F(DigitalPortTest, EstopAndInterlockAreLeftAlone) {
    ASSERT_TRUE(DigitalPort::start());
    DigitalInputs in;
    in.estop_closed = in.interlock_closed = true;
    DigitalPort::sample(in);
    EXPECT_TRUE(in.estop_closed && in.interlock_closed);
}

TEST_F(DigitalPortTest, EachOutputHasItsPin) {
    ASSERT_TRUE(DigitalPort::start());
    EXPECT_EQ(f.levels(), 0U);
    constexpr std::array<bool DigitalOutputs::*, 6> kOutputs{
        &DigitalOutputs::light_green, &DigitalOutputs::light_yellow, &DigitalOutputs::master_oscillator,
        &DigitalOutputs::guide_laser, &DigitalOutputs::shutter_open, &DigitalOutputs::light_red};
    for (unsigned i = 0; i < kOutputs.size(); ++i) {
        DigitalOutputs one;
        one.*kOutputs.at(i) = true;
        DigitalPort::write(one);
        EXPECT_EQ(f.levels(), 1U << (10 + i));
    }
    DigitalPort::make_safe();
    EXPECT_EQ(f.levels(), 0U);
}

TEST_F(DigitalPortTest, NothingIsOnWhenTheOutputsBeginWhateverWasThere) {
    ASSERT_TRUE(DigitalPort::start());
    DigitalOutputs all{true, true, true, true, true, true};
    DigitalPort::write(all);
    const std::uint32_t before = f.been_high();
    EXPECT_EQ(before, 0xFC00U);
    ASSERT_TRUE(DigitalPort::start());
    EXPECT_EQ(f.levels(), 0U);
}

}  // namespace
}  // namespace sc::stm32h743
