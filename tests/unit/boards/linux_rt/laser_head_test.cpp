// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/laser_head.hpp"

#include <memory>

#include <gtest/gtest.h>

#include "firmware/laser/head_proof.hpp"
#include "shared/link/config.hpp"

namespace sc::linux_rt {
namespace {

class FakeGate final : public GateLine {
public:
    void set(bool on) noexcept override { open = on; }
    bool open = false;
};

ServoOutputs marking() {
    ServoOutputs out;
    out.laser_size = 1;
    out.gate_allowed = true;
    return out;
}

TEST(FixedOptics, PassTheControllersProofOfAHead) {
    GalvoConfig galvo = reference_machine().galvo;
    laser::HeadProof proof(galvo);
    FixedOptics optics;
    const auto frames = std::make_unique<std::array<ServoOutputs, 2>>();
    int ticks = 0;
    for (; ticks < 100 && !proof.proven() && !proof.failed(); ++ticks) {
        // Frames of tick n are played in the window that ends at t_n+2.
        optics.play(frames->at(static_cast<std::size_t>(ticks) % 2));
        ServoOutputs& out = frames->at(static_cast<std::size_t>(ticks) % 2);
        for (GalvoFrame& frame : out.galvo) {
            frame.word_x = frame.word_z = 0x2'0000;
        }
        proof.step(optics.status(), out.galvo);
    }
    EXPECT_TRUE(proof.proven());
    EXPECT_LT(ticks, 40);
    EXPECT_EQ(optics.status(), kGalvoStatusOk);
}

TEST(NoLaser, IsNeverReadyAndItsShutterObeys) {
    NoLaser head;
    DigitalInputs in;
    in.laser_ready = true;
    head.sample(0, in);
    EXPECT_FALSE(in.laser_ready);
    EXPECT_TRUE(in.shutter_closed && !in.shutter_open);
    ServoOutputs out;
    out.digital.shutter_open = true;
    head.accept(0, out);
    head.sample(1, in);
    EXPECT_TRUE(in.shutter_open && !in.shutter_closed);
}

TEST(GatedHead, OpensForTheWindowOfATickWithPulses) {
    FakeGate gate;
    GatedHead head(gate);
    DigitalInputs in;
    const ServoOutputs light = marking();
    head.sample(0, in);
    head.accept(0, light);
    EXPECT_FALSE(gate.open);  // what tick 0 asks for acts from t_1 on
    head.sample(1, in);
    EXPECT_TRUE(gate.open);
    head.accept(1, ServoOutputs{});
    EXPECT_TRUE(gate.open);
    head.sample(2, in);
    EXPECT_FALSE(gate.open);
}

TEST(GatedHead, ShutsAtOnceOnACancelAndOnTheGuardsWord) {
    FakeGate gate;
    GatedHead head(gate);
    DigitalInputs in;
    ServoOutputs light = marking();
    head.accept(0, light);
    head.sample(1, in);
    ASSERT_TRUE(gate.open);
    light.cancel_laser = true;
    head.accept(1, light);
    EXPECT_FALSE(gate.open);
    head.accept(2, marking());
    head.sample(3, in);
    ASSERT_TRUE(gate.open);
    head.veto(1);
    EXPECT_FALSE(gate.open);
    head.accept(3, marking());
    head.sample(4, in);
    EXPECT_FALSE(gate.open);
    head.veto(0);
    head.sample(5, in);
    EXPECT_TRUE(gate.open);
}

TEST(Restrictions, LeaveAMachineThatAControllerCanRunWith) {
    MachineConfig machine = reference_machine();
    restrict_to_axes(machine);
    EXPECT_EQ(link::check(machine), Refusal::none);
    EXPECT_EQ(machine.galvo.half_field.si(), 0.0);
    restrict_to_gate(machine);
    EXPECT_EQ(link::check(machine), Refusal::none);
    // One pulse a tick: at 50 mm/s a pitch below 50 um is refused.
    EXPECT_DOUBLE_EQ(machine.laser.prr_nominal.si(), 1000.0);
}

}  // namespace
}  // namespace sc::linux_rt
