// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/laser.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace sc::sim {
namespace {

constexpr std::int64_t kAll = 1'000'000'000'000;

class Laser : public testing::Test {
protected:
    static LaserRun run(std::int64_t t0_ns, std::uint16_t count, std::int64_t period_ns = 12'500) {
        return {t0_ns, period_ns * 256, 0, count, 1, 255, 5'000};
    }
    static std::vector<LaserPulse> all(LaserPlant& laser, std::int64_t limit = kAll) {
        std::vector<LaserPulse> pulses;
        while (const auto pulse = laser.next(limit)) {
            pulses.push_back(*pulse);
        }
        return pulses;
    }
    /// With the master oscillator on long since.
    LaserPlant ready(double time_constant = 0.0) const {
        LaserTruth truth;
        truth.power_time_constant = time_constant;
        return ready(truth);
    }
    LaserPlant ready(const LaserTruth& truth) const {
        LaserPlant laser(config_, truth);
        laser.set_master_oscillator(true, -1'000'000'000);
        return laser;
    }
    LaserConfig config_ = reference_machine().laser;
};

TEST_F(Laser, EnergyIsPowerOverSourceRate) {
    LaserPlant laser = ready();
    laser.queue(run(0, 1), true);
    LaserRun picked = run(1'000'000, 1, 100'000);
    picked.pick = 4;
    picked.power = 51;
    laser.queue(picked, true);
    const auto pulses = all(laser);
    ASSERT_EQ(pulses.size(), 2U);
    EXPECT_EQ(pulses[0].energy_nj, 1'000'000U);  // 80 W / 80 kHz = 1 mJ
    EXPECT_EQ(pulses[1].energy_nj, 400'000U);    // 80 W · 51/255 / (4 · 10 kHz) = 0.4 mJ
    EXPECT_EQ(laser.counters().out_of_rate, 0U);
}

TEST_F(Laser, LightFollowsItsTriggerByTheLatency) {
    LaserPlant laser = ready();
    laser.queue(run(5'000'000, 3), true);
    const auto pulses = all(laser);
    ASSERT_EQ(pulses.size(), 3U);
    EXPECT_EQ(pulses[0].t_ns, 5'001'000);
    EXPECT_EQ(pulses[2].t_ns, 5'026'000);
}

TEST_F(Laser, ChangingPeriodPlacesPulsesByTheRunsFormula) {
    LaserPlant laser = ready();
    LaserRun r{1'000'000, 20'000 * 256, -77, 200, 1, 200, 5'000};
    laser.queue(r, true);
    const auto pulses = all(laser);
    ASSERT_EQ(pulses.size(), 200U);
    for (int k = 0; k < 200; ++k) {
        const double t = 1'000'000.0 + k * 20'000.0 - 77.0 / 256.0 * k * (k - 1) / 2.0;
        EXPECT_NEAR(static_cast<double>(pulses[static_cast<std::size_t>(k)].t_ns), t + 1000.0, 0.51);
        const double period = 20'000.0 - 77.0 / 256.0 * k;
        EXPECT_NEAR(pulses[static_cast<std::size_t>(k)].energy_nj, 80.0 * 200 / 255 * period, 1.0);
    }
}

TEST_F(Laser, GivesPulsesOnlyBeforeTheLimit) {
    LaserPlant laser = ready();
    laser.queue(run(0, 10, 20'000), true);
    EXPECT_EQ(all(laser, 1'000).size(), 0U);
    EXPECT_EQ(all(laser, 1'001).size(), 1U);
    EXPECT_EQ(all(laser, 101'001).size(), 5U);
    EXPECT_EQ(all(laser).size(), 4U);
}

TEST_F(Laser, PulsesWithinTheMasterOscillatorsWaitStayDark) {
    LaserPlant laser(config_, LaserTruth{});
    laser.queue(run(0, 1), true);
    EXPECT_FALSE(all(laser).at(0).lit);
    laser.set_master_oscillator(true, 1'000'000);
    laser.set_master_oscillator(true, 2'000'000);  // still on: the wait does not begin again
    laser.queue(run(8'999'999, 1), true);
    EXPECT_FALSE(all(laser).at(0).lit);
    laser.queue(run(9'000'000, 1), true);
    EXPECT_TRUE(all(laser).at(0).lit);
    laser.set_master_oscillator(false, 10'000'000);
    laser.set_master_oscillator(true, 11'000'000);
    laser.queue(run(12'000'000, 1), true);
    EXPECT_FALSE(all(laser).at(0).lit);
    EXPECT_EQ(laser.counters().unlit, 3U);
}

TEST_F(Laser, RunsOfATickThatDidNotAllowTheGateOnlyCount) {
    LaserPlant laser = ready();
    laser.queue(run(0, 7), false);
    EXPECT_TRUE(all(laser).empty());
    EXPECT_EQ(laser.counters().not_allowed, 7U);
}

TEST_F(Laser, CancelDropsFromItsTimeOnAndSparesLaterRuns) {
    LaserPlant laser = ready();
    laser.queue(run(0, 10, 20'000), true);
    laser.cancel(60'000);
    laser.queue(run(300'000, 2), true);
    const auto pulses = all(laser);
    ASSERT_EQ(pulses.size(), 5U);
    EXPECT_EQ(pulses[2].t_ns, 41'000);
    EXPECT_EQ(pulses[3].t_ns, 301'000);
    EXPECT_EQ(laser.counters().cancelled, 7U);
}

TEST_F(Laser, ShutGateDropsEveryTriggerUntilOpened) {
    LaserPlant laser = ready();
    laser.queue(run(0, 10, 20'000), true);
    laser.shut_gate(30'000);
    laser.shut_gate(90'000);  // shut already: the earlier time stands
    EXPECT_EQ(all(laser, 110'000).size(), 2U);
    laser.open_gate();
    EXPECT_EQ(all(laser).size(), 4U);
    EXPECT_EQ(laser.counters().cancelled, 4U);
}

TEST_F(Laser, HardLineCutsTheLightItself) {
    LaserPlant laser = ready();
    laser.queue(run(0, 10, 20'000), true);
    laser.cut_light(21'000);  // the light of trigger 1, already given, is cut too
    EXPECT_EQ(all(laser, 100'000).size(), 1U);
    laser.restore_light();
    EXPECT_EQ(all(laser).size(), 5U);
    EXPECT_EQ(laser.counters().cut, 4U);
}

TEST_F(Laser, SourceRateOutOfRangeIsCounted) {
    LaserPlant laser = ready();
    laser.queue(run(0, 1, 10'000), true);        // 100 kHz
    laser.queue(run(100'000, 1, 60'000), true);  // 16.7 kHz
    laser.queue(run(300'000, 1, 50'000), true);  // 20 kHz
    EXPECT_EQ(all(laser).size(), 3U);
    EXPECT_EQ(laser.counters().out_of_rate, 2U);
}

TEST_F(Laser, TriggersOutOfOrderAreCounted) {
    LaserPlant laser = ready();
    laser.queue(run(100'000, 1), true);
    laser.queue(run(50'000, 1), true);
    EXPECT_EQ(all(laser).size(), 2U);
    EXPECT_EQ(laser.counters().disordered, 1U);
}

TEST_F(Laser, PowerLagsItsByteByTheTimeConstant) {
    LaserPlant laser = ready(25e-6);
    laser.queue(run(0, 9, 12'500), true);
    const auto pulses = all(laser);
    for (std::size_t k = 0; k < pulses.size(); ++k) {
        // From the latch on, 5 us before the first trigger.
        const double expected = 1e6 * (1.0 - std::exp(-(5.0 + 12.5 * static_cast<double>(k)) / 25.0));
        EXPECT_NEAR(pulses[k].energy_nj, expected, 1.0) << k;
    }
}

TEST_F(Laser, TakesItsPowerByteAtTheLatchAlone) {
    LaserPlant laser = ready();
    laser.queue(run(100'000, 2), true);
    LaserRun unlatched = run(200'000, 1);
    unlatched.power = 51;
    unlatched.latch_ns = 0;
    laser.queue(unlatched, true);
    LaserRun latched = run(300'000, 1);
    latched.power = 51;
    laser.queue(latched, true);
    const auto pulses = all(laser);
    ASSERT_EQ(pulses.size(), 4U);
    EXPECT_EQ(pulses[1].energy_nj, 1'000'000U);
    EXPECT_EQ(pulses[2].energy_nj, 1'000'000U) << "the byte on the lines changes nothing by itself";
    EXPECT_EQ(pulses[3].energy_nj, 200'000U);
    EXPECT_EQ(laser.counters().wrong_power, 1U);
    EXPECT_EQ(laser.counters().strobes, 2U);
    EXPECT_EQ(laser.counters().bad_strobes, 0U);
}

TEST_F(Laser, ALatchThatComesEarlyChangesThePulsesBeforeItsRun) {
    LaserPlant laser = ready();
    laser.queue(run(100'000, 4), true);
    LaserRun early = run(150'000, 1);
    early.power = 51;
    early.latch_ns = 20'000;  // between the third and the last pulse of the run before
    laser.queue(early, true);
    const auto pulses = all(laser);
    ASSERT_EQ(pulses.size(), 5U);
    EXPECT_EQ(pulses[2].energy_nj, 1'000'000U);
    EXPECT_EQ(pulses[3].energy_nj, 200'000U);
    EXPECT_EQ(laser.counters().wrong_power, 1U);
}

TEST_F(Laser, AStrobeThatIsTooShortOrTooSoonTakesNoByte) {
    struct Case {
        void (*spoil)(LaserConfig&);
        const char* what;
    };
    for (const Case& c : {Case{[](LaserConfig& l) { l.latch_setup_ns = 999; }, "setup"},
                          Case{[](LaserConfig& l) { l.latch_width_ns = 1'999; }, "width"}}) {
        config_ = reference_machine().laser;
        c.spoil(config_);
        LaserPlant laser = ready();
        laser.queue(run(100'000, 3), true);
        EXPECT_EQ(all(laser).at(0).energy_nj, 0U) << c.what;
        EXPECT_EQ(laser.counters().bad_strobes, 1U) << c.what;
        EXPECT_EQ(laser.counters().wrong_power, 3U) << c.what;
    }
    config_ = reference_machine().laser;
    LaserPlant laser = ready();
    laser.queue(run(100'000, 1), true);
    LaserRun soon = run(103'000, 1);  // its byte is laid while the latch is still up
    soon.power = 51;
    soon.latch_ns = 4'300;
    laser.queue(soon, true);
    EXPECT_EQ(all(laser).at(1).energy_nj, 1'000'000U);
    EXPECT_EQ(laser.counters().bad_strobes, 1U);
}

TEST_F(Laser, ACancelledRunsStrobeIsDroppedToo) {
    LaserPlant laser = ready();
    laser.queue(run(100'000, 1), true);
    LaserRun cancelled = run(200'000, 1);
    cancelled.power = 51;
    laser.queue(cancelled, true);
    laser.cancel(150'000);
    LaserRun later = run(300'000, 1);
    later.latch_ns = 0;
    laser.queue(later, true);
    EXPECT_EQ(all(laser).at(1).energy_nj, 1'000'000U);
}

TEST_F(Laser, ClearedItsPowerIsNothing) {
    LaserPlant laser = ready();
    laser.queue(run(100'000, 1), true);
    EXPECT_EQ(all(laser).at(0).energy_nj, 1'000'000U);
    laser.clear_power(200'000);
    laser.clear_power(300'000);
    LaserRun later = run(400'000, 1);
    later.latch_ns = 0;
    laser.queue(later, true);
    EXPECT_EQ(all(laser).at(0).energy_nj, 0U);
    EXPECT_EQ(laser.counters().strobes, 2U) << "once";
}

TEST_F(Laser, FirstPulsesAfterAPauseAreStrongerAsTheGainHasBuiltUp) {
    LaserTruth truth;
    truth.first_pulse_excess = 0.2;
    truth.gain_build_up = 100e-6;
    truth.first_pulses = 4.0;
    LaserPlant laser = ready(truth);
    laser.queue(run(0, 40), true);
    // 100 us, one time constant, beyond the period of 12.5 us.
    laser.queue(run(39 * 12'500 + 112'500, 2), true);
    const auto pulses = all(laser);
    ASSERT_EQ(pulses.size(), 42U);
    EXPECT_EQ(pulses[0].energy_nj, 1'200'000U);
    EXPECT_EQ(pulses[1].energy_nj, 1'150'000U);
    EXPECT_EQ(pulses[2].energy_nj, 1'112'500U);
    EXPECT_NEAR(pulses[39].energy_nj, 1'000'000.0, 10.0) << "a steady rate builds nothing up";
    EXPECT_NEAR(pulses[40].energy_nj, 1e6 * (1.0 + 0.2 * (1.0 - std::exp(-1.0))), 20.0);
}

}  // namespace
}  // namespace sc::sim
