// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/pulse_placer.hpp"

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

namespace sc::laser {
namespace {

constexpr double kTick = 1e-3;
constexpr std::int64_t kTickNs = 1'000'000;

PulseSpec spec() {
    PulseSpec s;
    s.path = 7;
    s.pitch = 20e-6;
    s.energy = 300e-6;
    s.speed_min = 2e-3;
    s.prr_min = 20e3;
    s.prr_nominal = 80e3;
    s.power = 80.0;
    return s;
}

struct Fired {
    std::vector<PathPulse> pulses;
    std::vector<double> trigger_ns;  ///< as the runs give them
    std::vector<LaserRun> runs;
};

/// Runs a path with points along x and z and collects all pulses.
Fired fire(const std::vector<motion::Place>& points, double speed, std::int64_t act_ns, double acceleration = 5.0,
           double jerk = 200.0) {
    auto motion = std::make_unique<motion::PathMotion>();
    trajectory::Spec path;
    path.speed = speed;
    path.tolerance = 1e-5;
    path.limits.speed = {2.0, 2.0, 2.0, 1.0};
    path.limits.acceleration = {acceleration, acceleration, acceleration, 1.0};
    path.limits.jerk = {jerk, jerk, jerk, 1.0};
    EXPECT_TRUE(motion->open(path));
    for (std::size_t i = 0; i < points.size(); ++i) {
        motion->add(points[i], static_cast<std::uint32_t>(i));
    }
    motion->finish();
    PulsePlacer placer;
    placer.open(spec());
    Fired fired;
    double t = 0.0;
    std::int64_t ns = 0;
    for (std::int64_t tick = 0; tick < 100'000; ++tick) {
        EXPECT_TRUE(motion->tick(t, kTick));
        motion->work(motion::kUnitsPerTick);
        if (t == 0.0 && !motion->ready()) {
            continue;
        }
        auto out = std::make_unique<ServoOutputs>();
        placer.place(*motion, ns, ns + kTickNs, act_ns, *out);
        fired.pulses.insert(fired.pulses.end(), out->pulses.begin(),
                            out->pulses.begin() + static_cast<std::ptrdiff_t>(out->pulses_size));
        for (std::size_t r = 0; r < out->laser_size; ++r) {
            const LaserRun& run = out->laser[r];
            fired.runs.push_back(run);
            double period = static_cast<double>(run.period_ns256) / 256.0;
            double at = static_cast<double>(run.t0_ns);
            for (int k = 0; k < run.count; ++k) {
                fired.trigger_ns.push_back(at);
                at += period;
                period += static_cast<double>(run.change_ns256) / 256.0;
            }
        }
        ns += kTickNs;
        t = static_cast<double>(ns) * 1e-9;
        if (placer.done(*motion)) {
            break;
        }
    }
    EXPECT_EQ(placer.withheld(), 0U);
    return fired;
}

TEST(PulsePlacer, PutsPulsesAtEqualPitchThroughRampsAndCorners) {
    const Fired fired = fire({{0, 0, 0, 0}, {0.01, 0, 0, 0}, {0.01, 0, 0.01, 0}, {0.02, 0, 0.012, 0}}, 0.1, 0);
    ASSERT_GT(fired.pulses.size(), 1500U);
    for (std::size_t i = 0; i < fired.pulses.size(); ++i) {
        ASSERT_EQ(fired.pulses[i].number, i);
        ASSERT_EQ(fired.pulses[i].s_pm, static_cast<std::int64_t>(i) * 20'000'000);
    }
    // A chord is shorter than its arc where a blend turns 90° within four pulses.
    int short_chords = 0;
    for (std::size_t i = 1; i < fired.pulses.size(); ++i) {
        const auto& a = fired.pulses[i - 1].place_pm;
        const auto& b = fired.pulses[i].place_pm;
        const double chord = std::hypot(static_cast<double>(b[0] - a[0]), static_cast<double>(b[2] - a[2]));
        ASSERT_LE(chord, 20e6 + 6000.0) << "two pulses may each be 1 nm off, and the distance in a corner 4 nm";
        short_chords += chord < 20e6 - 6000.0 ? 1 : 0;
        ASSERT_GT(chord, 18.5e6);
    }
    EXPECT_LE(short_chords, 12);
}

TEST(PulsePlacer, KeepsEachPulseOfAGroupWithinANanometre) {
    // A stop in the middle, so that the speed changes fast: on a straight line place and distance are the same.
    for (const double acceleration : {5.0, 200.0, 8000.0}) {
        const Fired fired = fire({{0, 0, 0, 0}, {0.003, 0, 0, 0}, {0.003, 0, 0.0001, 0}, {0.006, 0, 0.0001, 0}}, 1.5, 0,
                                 acceleration, acceleration * 1e4);
        int checked = 0;
        for (const PathPulse& pulse : fired.pulses) {
            if (pulse.s_pm < 2'900'000'000) {
                ASSERT_NEAR(static_cast<double>(pulse.place_pm[0]), static_cast<double>(pulse.s_pm), 1100.0)
                    << acceleration << " " << pulse.number;
                ++checked;
            }
        }
        EXPECT_GT(checked, 140);
    }
}

TEST(Firing, DoesNotDependOnWhereItLooksFirst) {
    const FiringRule rule(spec());
    for (double v = 2e-3; v <= 1.6; v *= 1.03) {
        const Firing right = rule.at(v, 1);
        for (const std::uint32_t hint : {2U, 7U, 40U, 255U}) {
            const Firing f = rule.at(v, hint);
            ASSERT_TRUE(f.pick == right.pick && f.power == right.power && f.possible == right.possible) << v;
        }
    }
}

TEST(PulsePlacer, RunsGiveEveryPulseItsTime) {
    const std::int64_t act = 123'456'789;
    const Fired fired = fire({{0, 0, 0, 0}, {0.01, 0, 0, 0}, {0.01, 0, 0.005, 0}}, 0.1, act);
    ASSERT_EQ(fired.trigger_ns.size(), fired.pulses.size());
    for (std::size_t i = 0; i < fired.pulses.size(); ++i) {
        ASSERT_NEAR(fired.trigger_ns[i], static_cast<double>(fired.pulses[i].t_ns + act), 4.0) << i;
    }
    EXPECT_LT(fired.runs.size() * 2, fired.pulses.size()) << "pulses leave as runs, not one by one";
}

TEST(Firing, KeepsTheEnergyWhileTheRateChanges) {
    for (double v = 2e-3; v <= 1.6; v *= 1.01) {
        const Firing f = firing_at(v, spec());
        ASSERT_TRUE(f.possible) << v;
        const double prr = v / spec().pitch * f.pick;
        ASSERT_GE(prr, 20e3 * 0.999);
        ASSERT_LE(prr, 80e3 * 1.001);
        const double energy = spec().power * f.power / 255.0 / prr;
        ASSERT_NEAR(energy / spec().energy, 1.0, 0.5 / (f.power - 0.5)) << v;
    }
}

TEST(Firing, FollowsAMeasuredCurveAndKeepsTheEnergy) {
    PulseSpec bent = spec();
    bent.curve.count = 5;
    bent.curve.byte = {10, 60, 120, 190, 255};
    bent.curve.watts = {1.0, 6.0, 20.0, 55.0, 78.0};
    bent.power = 78.0;
    const auto watts_at = [&](double code) {
        std::size_t i = 0;
        while (i + 2 < bent.curve.count && code > bent.curve.byte[i + 1]) {
            ++i;
        }
        const double share = (code - bent.curve.byte[i]) / (bent.curve.byte[i + 1] - bent.curve.byte[i]);
        return bent.curve.watts[i] + share * (bent.curve.watts[i + 1] - bent.curve.watts[i]);
    };
    for (const double energy : {60e-6, 300e-6, 900e-6}) {
        bent.energy = energy;
        const FiringRule rule(bent);
        for (double v = 2e-3; v <= 1.6; v *= 1.01) {
            const Firing f = rule.at(v, 1);
            ASSERT_TRUE(f.possible) << v;
            const double wanted = energy * v / bent.pitch * f.pick;
            const double low = watts_at(f.power - 0.501);
            const double high = watts_at(f.power + 0.501);
            ASSERT_LE(low, wanted) << energy << " at " << v;
            ASSERT_GE(f.power == 255 ? 1e9 : high, wanted) << energy << " at " << v;
        }
    }
}

TEST(FiringRule, TheByteStaysWhereItSetsTheEnergyOfAPulse) {
    PulseSpec s = spec();
    s.power_byte = PowerByte::pulse_energy;
    const std::uint32_t byte = firing_at(1.6, s).power;
    EXPECT_EQ(byte, firing_at(1.6, spec()).power) << "at the nominal rate both mean the same";
    for (double v = 0.05; v <= 1.6; v += 0.01) {
        ASSERT_EQ(firing_at(v, s).power, byte) << v;
        ASSERT_EQ(firing_at(v, s).pick, firing_at(v, spec()).pick) << v;
    }
}

TEST(Firing, IsImpossibleBelowTheLowestSpeedAndAboveTheHighestRate) {
    EXPECT_FALSE(firing_at(1.99e-3, spec()).possible);
    EXPECT_FALSE(firing_at(0.0, spec()).possible);
    EXPECT_FALSE(firing_at(1.7, spec()).possible);
    EXPECT_FALSE(firing_at(std::nan(""), spec()).possible);
}

}  // namespace
}  // namespace sc::laser
