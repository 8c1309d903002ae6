// SPDX-License-Identifier: Apache-2.0
#include "host/verification/pulse_checker.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

namespace sc::host {
namespace {

constexpr double kPitch = 50e-6;
constexpr std::int64_t kPeriodNs = 25'000;

PathPoint at(double x_mm, double z_mm) {
    return {static_cast<std::int32_t>(std::lround(x_mm * 1e5)), -21'000'000,
            static_cast<std::int32_t>(std::lround(z_mm * 1e5))};
}

PathBegin begin(std::uint32_t path) {
    PathBegin b;
    b.path = path;
    b.pitch_nm = 50'000;
    b.energy_nj = 1'000'000;
    return b;
}

/// Two paths: an angle whose corner lies between two pulses, and half a circle of 2 mm.
std::vector<DrawnJobPath> job() {
    return draw({Turn{0}, begin(3), at(1.0, 1.0), at(4.02, 1.0), at(4.02, 3.0), PathEnd{}, begin(4), at(2.0, 0.0),
                 PathArc{at(0.0, 2.0), at(-2.0, 0.0)}, PathEnd{}, JobEnd{}});
}

trace::PulseRecord pulse(double x, double z, std::int64_t t_ns) {
    trace::PulseRecord p;
    p.t_ns = t_ns;
    p.place_pm = {std::llround(x * 1e12), -210'000'000'000, std::llround(z * 1e12)};
    p.energy_nj = 1'000'000;
    p.hit = 1;
    return p;
}

/// As the job wants them, by hand: no DrawnPath here.
std::vector<trace::PulseRecord> ideal() {
    std::vector<trace::PulseRecord> pulses;
    std::int64_t t = 0;
    for (int k = 0; k <= 100; ++k, t += kPeriodNs) {
        const double s = k * kPitch;
        pulses.push_back(s <= 3.02e-3 ? pulse(1e-3 + s, 1e-3, t) : pulse(4.02e-3, 1e-3 + (s - 3.02e-3), t));
    }
    t += 20'000'000;
    for (int k = 0; k * kPitch <= 2e-3 * std::numbers::pi; ++k, t += kPeriodNs) {
        const double a = k * kPitch / 2e-3;
        pulses.push_back(pulse(2e-3 * std::cos(a), 2e-3 * std::sin(a), t));
    }
    return pulses;
}

TEST(PulseChecker, FindsNothingWrongWithWhatTheJobAsksFor) {
    const PulseFigures f = check_pulses(job(), ideal());
    EXPECT_EQ(f.pulses, ideal().size());
    EXPECT_EQ(f.lost, 0U);
    EXPECT_EQ(f.drift, 0.0);
    EXPECT_LT(f.placement_peak, 1e-11);
    EXPECT_LT(f.pitch_peak, 1e-6);
    EXPECT_LT(f.energy_peak, 1e-9);
    EXPECT_LT(f.energy_per_length_peak, 1e-6);
}

TEST(PulseChecker, TakesTheAxesStandOutAndNothingElse) {
    auto pulses = ideal();
    for (auto& p : pulses) {
        p.place_pm[0] += 3'000'000;
        p.place_pm[2] -= 2'000'000;
    }
    EXPECT_LT(check_pulses(job(), pulses).placement_peak, 1e-11);
    EXPECT_LT(check_pulses(job(), pulses).pitch_peak, 1e-6) << "not even at the corner";
    EXPECT_NEAR(check_pulses(job(), pulses, {.stand = Vec3{}}).placement_peak, std::hypot(3e-6, 2e-6), 1e-11);
    pulses[50].place_pm[2] += 4'000'000;
    const PulseFigures f = check_pulses(job(), pulses);
    EXPECT_NEAR(f.placement_peak, 4e-6, 0.1e-6);
    EXPECT_LT(f.pitch_peak, 1e-3) << "across the path";
}

TEST(PulseChecker, SeesAPulseThatIsLateAlongThePath) {
    auto pulses = ideal();
    pulses[20].place_pm[0] += 2'000'000;
    const PulseFigures f = check_pulses(job(), pulses);
    EXPECT_NEAR(f.pitch_peak, 0.04, 1e-4);
    EXPECT_NEAR(f.placement_peak, 2e-6, 0.1e-6);
    EXPECT_NEAR(f.pitch_rms, std::sqrt(2.0 * 0.04 * 0.04 / (100.0 + 125.0)), 1e-4);
}

TEST(PulseChecker, SeesEnergyOfAPulseAndOfAMillimetre) {
    auto pulses = ideal();
    pulses[10].energy_nj = 1'050'000;
    PulseFigures f = check_pulses(job(), pulses);
    EXPECT_NEAR(f.energy_peak, 0.05, 1e-9);
    EXPECT_NEAR(f.energy_per_length_peak, 0.05 / 20.0, 1e-6);
    for (auto& p : pulses) {
        p.energy_nj = 900'000;
    }
    f = check_pulses(job(), pulses);
    EXPECT_NEAR(f.energy_per_length_peak, 0.1, 1e-6);
}

TEST(PulseChecker, SeesAPulseThatIsMissingOrTooMany) {
    auto pulses = ideal();
    pulses.erase(pulses.begin() + 30);
    PulseFigures f = check_pulses(job(), pulses);
    EXPECT_EQ(f.lost, 1U);
    EXPECT_EQ(f.drift, 1.0);
    EXPECT_GT(f.pitch_peak, 0.9);
    pulses = ideal();
    pulses.insert(pulses.begin() + 30, pulses[30]);
    f = check_pulses(job(), pulses);
    EXPECT_EQ(f.lost, 1U);
    EXPECT_GT(f.pitch_peak, 0.9);
}

TEST(PulseChecker, SeesAPitchThatIsTooLongByALittleAtTheEndOfThePath) {
    auto pulses = ideal();
    // 2 % more: each pulse is nearly where it should be to the next, and the hundredth is two too far.
    for (int k = 0; k <= 60; ++k) {
        pulses[static_cast<std::size_t>(k)].place_pm[0] += std::llround(0.02 * k * 50e6);
    }
    const PulseFigures f = check_pulses(job(), pulses, {.only = std::vector<std::uint32_t>{3}});
    EXPECT_NEAR(f.pitch_rms, 0.0, 0.15);
    EXPECT_GT(f.placement_peak, 20e-6);
}

TEST(PulseChecker, JudgesSomePathsOnlyAndRefusesOtherPathsThanTheJobs) {
    auto pulses = ideal();
    pulses[20].place_pm[0] += 2'000'000;
    EXPECT_LT(check_pulses(job(), pulses, {.only = std::vector<std::uint32_t>{4}}).placement_peak, 1e-11);
    pulses.resize(101);
    EXPECT_THROW(static_cast<void>(check_pulses(job(), pulses)), std::domain_error);
}

TEST(DrawnPath, ArcsGoThroughTheirThreePlacesEitherWay) {
    for (const double way : {1.0, -1.0}) {
        DrawnPath path;
        path.meet(true, at(3.0, 0.0));
        path.arc(at(0.0, 3.0 * way), at(0.0, -3.0 * way));
        EXPECT_NEAR(path.length(), 1.5 * std::numbers::pi * 3e-3, 1e-12);
        EXPECT_NEAR(path.at(0.5 * std::numbers::pi * 3e-3).z, way * 3e-3, 1e-12);
        EXPECT_NEAR(path.at(path.length()).x, 0.0, 1e-12);
        EXPECT_NEAR(path.nearest({-2.9e-3, -0.21, 0.0}, 0.0, 1.0), std::numbers::pi * 3e-3, 1e-9);
    }
}

TEST(DrawnPath, RefusesAnArcThatIsALine) {
    DrawnPath path;
    path.meet(true, at(0.0, 0.0));
    EXPECT_THROW(path.arc(at(1.0, 0.0), at(2.0, 0.0)), std::domain_error);
}

const PulseCheck kLimited{.stand_each = true, .limits = PulseLimits{}};

std::vector<PulseBreach> breaches(const PulseFigures& figures) {
    std::vector<PulseBreach> found;
    for (const PulseViolation& v : figures.first) {
        found.push_back(v.breach);
    }
    return found;
}

TEST(PulseChecker, KeepsLimitsWhenNothingIsWrong) {
    const PulseFigures f = check_pulses(job(), ideal(), kLimited);
    EXPECT_EQ(f.violations, 0U);
    EXPECT_EQ(f.pulses, ideal().size());
}

TEST(PulseChecker, NamesThePulseThatBreaksALimit) {
    std::vector<trace::PulseRecord> pulses = ideal();
    pulses[20].place_pm[0] += 2'000'000;  // 4 % of the pitch
    PulseFigures f = check_pulses(job(), pulses, kLimited);
    ASSERT_EQ(breaches(f), (std::vector{PulseBreach::pitch, PulseBreach::pitch}));
    EXPECT_EQ(f.first[0].path, 3U);
    EXPECT_EQ(f.first[0].pulse, 20U);
    EXPECT_EQ(f.first[0].t_ns, pulses[20].t_ns);
    EXPECT_NEAR(f.first[0].value, 1.04, 1e-6);
    EXPECT_NEAR(f.first[0].limit, 1.03, 1e-12);
    EXPECT_NEAR(f.first[1].value, 0.96, 1e-6);

    pulses = ideal();
    pulses[7].energy_nj = 1'160'000;
    f = check_pulses(job(), pulses, kLimited);
    EXPECT_EQ(breaches(f), std::vector{PulseBreach::energy}) << "16 % of one pulse, 0.8 % of its millimetre";
    pulses = ideal();
    for (trace::PulseRecord& pulse : pulses) {
        pulse.energy_nj = 1'030'000;
    }
    f = check_pulses(job(), pulses, kLimited);
    EXPECT_GT(f.violations, 0U);
    EXPECT_EQ(f.first[0].breach, PulseBreach::energy_per_length);
}

TEST(PulseChecker, AllowsForCornersThatAreCutAndForNothingElse) {
    std::vector<trace::PulseRecord> pulses = ideal();
    pulses.erase(pulses.begin() + 99, pulses.begin() + 101);
    EXPECT_EQ(breaches(check_pulses(job(), pulses, kLimited)), std::vector{PulseBreach::count});
    std::vector<Item> items{Turn{0}, begin(3), at(1.0, 1.0), at(4.02, 1.0), at(4.02, 3.0), PathEnd{}, JobEnd{}};
    std::get<PathBegin>(items[1]).tolerance_nm = 50'000;
    pulses.resize(99);
    EXPECT_EQ(check_pulses(draw(items), pulses, kLimited).violations, 0U) << "100 um less, and a corner of 50 um";
}

TEST(PulseChecker, KnowsDarkStretchesOfAPath) {
    // 1 mm marked, 1 mm dark, 0.52 mm marked.
    const auto path = draw({Turn{0}, begin(3), at(0.0, 0.0), at(1.0, 0.0), PathLight{false}, at(2.0, 0.0),
                            PathLight{true}, at(2.52, 0.0), PathEnd{}, JobEnd{}});
    ASSERT_EQ(path.size(), 2U);
    EXPECT_EQ(path[0].pulses(), 21U);
    EXPECT_EQ(path[1].pulses(), 11U);
    std::vector<trace::PulseRecord> pulses;
    for (int k = 0; k <= 20; ++k) {
        pulses.push_back(pulse(k * kPitch, 0.0, k * kPeriodNs));
    }
    for (int k = 0; k <= 10; ++k) {
        pulses.push_back(pulse(2e-3 + k * kPitch, 0.0, (40 + k) * kPeriodNs));
    }
    EXPECT_EQ(check_pulses(path, pulses, kLimited).violations, 0U);
    pulses.push_back(pulse(1.5e-3, 0.0, 100 * kPeriodNs));
    EXPECT_EQ(breaches(check_pulses(path, pulses, kLimited)), std::vector{PulseBreach::paths}) << "light in the dark";
}

TEST(PulseChecker, MeasuresALineAsItLiesInSpace) {
    PathPoint deep = at(3.0, 0.0);
    deep.y += 400'000;
    const auto path = draw({Turn{0}, begin(3), at(0.0, 0.0), deep, PathEnd{}, JobEnd{}});
    ASSERT_EQ(path[0].pulses(), 101U) << "3, 4, 5";
    std::vector<trace::PulseRecord> pulses;
    for (int k = 0; k <= 100; ++k) {
        pulses.push_back(pulse(0.6 * k * kPitch, 0.0, k * kPeriodNs));
    }
    EXPECT_EQ(check_pulses(path, pulses, kLimited).violations, 0U);
}

TEST(PulseChecker, CountsPulsesThatMetNothingAndThoseOfAShutGate) {
    std::vector<trace::PulseRecord> pulses = ideal();
    trace::PulseRecord stray = pulses[10];
    stray.hit = 0;
    stray.place_pm = {};
    stray.t_ns += 1;
    pulses.insert(pulses.begin() + 11, stray);
    PulseFigures f = check_pulses(job(), pulses, kLimited);
    EXPECT_EQ(breaches(f), std::vector{PulseBreach::missed});

    // The first path takes 2.5 ms from time 0, the second begins 20 ms later.
    pulses = ideal();
    GateTicks gate{.first_tick = -1, .period_ns = 1'000'000, .open = std::vector<bool>(40, true)};
    f = check_pulses(job(), pulses, kLimited);
    check_gate(pulses, gate, f);
    EXPECT_EQ(f.violations, 0U);
    gate.open[1] = false;
    check_gate(pulses, gate, f);
    EXPECT_EQ(f.violations, 39U) << "1.000 ms counts as the end of the tick before";
    EXPECT_EQ(f.first[0].breach, PulseBreach::gate_shut);
    EXPECT_EQ(f.first[0].pulse, 41U);
}

}  // namespace
}  // namespace sc::host
