// SPDX-License-Identifier: Apache-2.0
// The shutter with its read-back, the key, and what the source says of itself.
#include <string>

#include <gtest/gtest.h>

#include "cell_rig.hpp"
#include "shared/machine/source_status.hpp"
#include "undisturbed.hpp"

namespace sc::test {
namespace {

void make_idle(CellRig& rig) {
    rig.connect();
    ASSERT_TRUE(rig.until_state(State::disabled, 5000));
    ASSERT_EQ(rig.command(link::Verb::enable).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::idle, 5000));
    ASSERT_EQ(rig.command(link::Verb::home).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::homing, 100));
    ASSERT_TRUE(rig.until_state(State::idle, 120'000));
}

CellRig::Options with_script(const std::string& script) {
    CellRig::Options options;
    options.script = script;
    return options;
}

TEST(Beam, TheShutterIsOpenBeforeTheMasterOscillatorComesOnAndShutWhenItIsOff) {
    CellRig rig;
    make_idle(rig);
    EXPECT_EQ(rig.cell().plant().beam_counters().shutter_ns, 0) << "shut until armed";
    ASSERT_EQ(rig.command(link::Verb::arm).refusal, 0);
    ASSERT_TRUE(rig.until([&] { return rig.cell().latest().digital.master_oscillator; }, 1000));
    EXPECT_NE(rig.status().flags & link::kFlagShutterOpen, 0);
    ASSERT_TRUE(rig.until_state(State::armed, 100));
    ASSERT_EQ(rig.command(link::Verb::disarm).refusal, 0);
    rig.ticks(100);
    EXPECT_EQ(rig.status().flags & link::kFlagShutterOpen, 0);
    EXPECT_EQ(rig.state(), State::idle);
}

TEST(Beam, AShutterThatDoesNotOpenIsAFaultWithinHalfASecondAndNoLightComesOn) {
    CellRig rig(with_script("at 0.1 shutter stuck\n"));
    make_idle(rig);
    const std::int64_t asked_ns = rig.cell().now_ns();
    ASSERT_EQ(rig.command(link::Verb::arm).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::fault, 1000));
    EXPECT_LE(rig.cell().now_ns() - asked_ns, 530'000'000) << "the command's way over the link included";
    rig.ticks(30);
    EXPECT_EQ(rig.status().first_fault, static_cast<std::uint8_t>(Fault::shutter));
    EXPECT_EQ(rig.cell().plant().beam_counters().master_oscillator_ns, 0);
}

TEST(Beam, AShutterThatDoesNotShutIsAFaultThatStaysUntilItDoes) {
    CellRig rig;
    rig.make_ready();
    rig.cell().plant().shutter().stick(true);
    ASSERT_EQ(rig.command(link::Verb::disarm).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::fault, 520));
    rig.ticks(30);
    EXPECT_EQ(rig.status().first_fault, static_cast<std::uint8_t>(Fault::shutter));
    const auto reply = rig.command(link::Verb::reset_fault);
    EXPECT_EQ(static_cast<Refusal>(reply.refusal), Refusal::fault_present);
    EXPECT_EQ(reply.detail, static_cast<int>(Fault::shutter));
    rig.cell().plant().shutter().stick(false);
    rig.ticks(100);
    EXPECT_EQ(rig.command(link::Verb::reset_fault).refusal, 0);
    EXPECT_EQ(rig.state(), State::disabled);
}

TEST(Beam, ASourceThatWarnsGoesOnAndIsHeard) {
    CellRig rig(with_script("at 0.1 laser warning\n"));
    rig.make_ready();
    ASSERT_EQ(rig.open_job(short_job()).refusal, 0);
    ASSERT_EQ(rig.command(link::Verb::start).refusal, 0);
    ASSERT_TRUE(rig.until([&] { return (rig.status().flags & link::kFlagJobDone) != 0; }, 60'000));
    EXPECT_EQ(rig.status().source, static_cast<std::uint8_t>(SourceState::warning));
    EXPECT_EQ(rig.pulses().size(), undisturbed().pulses().size());
}

TEST(Beam, ASourceThatStartsUpOrIsIllCannotBeArmed) {
    for (const auto& [what, state] :
         {std::pair{"starting", SourceState::not_ready}, std::pair{"temperature", SourceState::temperature}}) {
        CellRig rig(with_script(std::string("at 0.1 laser ") + what + "\n"));
        make_idle(rig);
        const auto reply = rig.command(link::Verb::arm);
        EXPECT_EQ(static_cast<Refusal>(reply.refusal), Refusal::laser_not_ready) << what;
        EXPECT_EQ(reply.detail, static_cast<int>(state)) << what;
        EXPECT_EQ(rig.status().source, static_cast<std::uint8_t>(state)) << what;
    }
}

TEST(Beam, AnAlarmOfTheSourceMustBeGoneBeforeItsFaultIsReset) {
    CellRig rig(with_script("pulse 100 laser back_reflection\nat 60 laser ok\n"));
    rig.make_ready();
    ASSERT_EQ(rig.open_job(short_job()).refusal, 0);
    ASSERT_EQ(rig.command(link::Verb::start).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::fault, 20'000));
    const auto early = rig.command(link::Verb::reset_fault);
    EXPECT_EQ(static_cast<Refusal>(early.refusal), Refusal::fault_present);
    EXPECT_EQ(early.detail, static_cast<int>(Fault::laser_back_reflection));
    rig.until([&] { return rig.cell().now_ns() > 60'100'000'000; });
    EXPECT_EQ(rig.command(link::Verb::reset_fault).refusal, 0);
}

TEST(Beam, EveryPulseIsMadeWithTheByteItWasPlannedFor) {
    // The bent line has ramps and a corner: the byte follows the rate of the source all along.
    const sim::LaserCounters& laser = undisturbed().cell().plant().laser_counters();
    EXPECT_GT(laser.strobes, 50U);
    EXPECT_EQ(laser.bad_strobes, 0U);
    EXPECT_EQ(laser.wrong_power, 0U);
}

TEST(Beam, ABoardWithTooShortAStrobeLosesTheEnergy) {
    CellRig::Options options;
    options.machine.laser.latch_setup_ns = 500;
    CellRig rig(options);
    rig.make_ready();
    ASSERT_EQ(rig.open_job(short_job()).refusal, 0);
    ASSERT_EQ(rig.command(link::Verb::start).refusal, 0);
    ASSERT_TRUE(rig.until([&] { return (rig.status().flags & link::kFlagJobDone) != 0; }, 60'000));
    const sim::LaserCounters& laser = rig.cell().plant().laser_counters();
    EXPECT_GT(laser.bad_strobes, 0U);
    EXPECT_EQ(laser.wrong_power, rig.pulses().size());
    EXPECT_EQ(rig.pulses().at(0).energy_nj, 0U);
}

TEST(Beam, ThePowerByteIsNoughtBeforeTheMasterOscillatorIsOnAndAfterAFault) {
    CellRig rig(with_script("pulse 100 laser system\n"));
    rig.make_ready();
    EXPECT_FALSE(rig.cell().latest().clear_power);
    ASSERT_EQ(rig.open_job(short_job()).refusal, 0);
    ASSERT_EQ(rig.command(link::Verb::start).refusal, 0);
    ASSERT_TRUE(rig.until_state(State::fault, 20'000));
    rig.ticks(3);
    EXPECT_TRUE(rig.cell().latest().clear_power);
    const std::uint64_t strobes = rig.cell().plant().laser_counters().strobes;
    rig.ticks(20);
    EXPECT_EQ(rig.cell().plant().laser_counters().strobes, strobes) << "cleared once";
}

TEST(Beam, EverySourceArmsByItsOwnTable) {
    for (const LaserSource source : {LaserSource::none, LaserSource::ipg, LaserSource::raycus, LaserSource::jpt}) {
        CellRig::Options options;
        options.machine.laser.source = source;
        CellRig rig(options);
        rig.make_ready();
        EXPECT_EQ(rig.state(), State::armed) << static_cast<int>(source);
    }
}

}  // namespace
}  // namespace sc::test
