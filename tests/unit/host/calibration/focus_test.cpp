// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "host/calibration/focus_fit.hpp"
#include "host/calibration/step_depths.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr MarkWidth kMark{.waist = 16e-6, .rayleigh = 0.6e-3, .reach = 2.5e-4, .curvature = 0.0};

std::vector<Rung> ladder(double focus, double from, double to, double sigma, unsigned seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::vector<Rung> out;
    for (int i = 0; i < 21; ++i) {
        const double y = from + (to - from) * i / 20.0;
        out.push_back({i + 1, y, kMark.at(focus - y) + sigma * normal(random), sigma});
    }
    return out;
}

std::string refusal_of(const std::vector<Rung>& rungs) {
    try {
        static_cast<void>(fit_focus("widths.csv", rungs));
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TEST(FocusFit, FindsTheFocusAndItsStatedErrorHolds) {
    double sum = 0.0;
    constexpr int kSets = 40;
    for (unsigned seed = 0; seed < kSets; ++seed) {
        const FocusFit fit = fit_focus("widths.csv", ladder(-0.2103, -0.212, -0.208, 3e-6, seed));
        EXPECT_LT(fit.sigma, 25e-6);
        EXPECT_NEAR(fit.mark.rayleigh, 0.6e-3, 0.15e-3);
        sum += std::pow((fit.y + 0.2103) / fit.sigma, 2);
    }
    EXPECT_NEAR(sum / kSets, 1.0, 4.0 * std::sqrt(2.0 / kSets));
}

TEST(FocusFit, NamesAWrongRungAndRefusesAOneSidedLadder) {
    auto rungs = ladder(-0.2103, -0.212, -0.208, 3e-6, 3);
    rungs[4].width += 60e-6;
    const FocusFit fit = fit_focus("widths.csv", rungs);
    EXPECT_EQ(fit.wrong, std::vector<int>{5});
    EXPECT_NEAR(fit.y, -0.2103, 60e-6);
    EXPECT_FALSE(refusal_of(ladder(-0.2103, -0.2105, -0.208, 3e-6, 4)).empty());
    rungs.resize(5);
    EXPECT_NE(refusal_of(rungs).find("too few rungs"), std::string::npos);
}

Target stepped() {
    Target target;
    target.kind = TargetKind::mobile;
    target.steps = {{1, 0.0, 0.0, {}}, {2, 5.01e-3, 1e-6, {}}, {3, 15.02e-3, 1e-6, {}}};
    for (int i = 0; i < 12; ++i) {
        target.markers.push_back({i + 1, {}, 0.0});
        target.steps[static_cast<std::size_t>(i) % 3].markers.push_back(i + 1);
    }
    return target;
}

/// A target that leans by 2 and −1 mrad, seen by a sensor whose gain is 400 ppm too large.
std::vector<DepthReading> readings_of(const Target& target, double sigma, unsigned seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::vector<DepthReading> out;
    for (const TargetMarker& marker : target.markers) {
        const double x = 0.05 * (marker.id % 4) - 0.3;
        const double z = 0.02 * (marker.id % 5) - 0.3;
        const double height = target.steps[static_cast<std::size_t>(marker.id - 1) % 3].height;
        const double y = -0.25 + 2e-3 * (x + 0.3) - 1e-3 * (z + 0.3) + height;
        out.push_back({marker.id, {x, -0.25, z}, (0.125 - (y + 0.25)) * 1.0004 + sigma * normal(random), 2e-6});
    }
    return out;
}

TEST(StepDepths, TakesTheSensorsGainOutByTheSteps) {
    const Target target = stepped();
    const auto readings = readings_of(target, 2e-6, 1);
    const double first = -0.25 + 2e-3 * 0.05 - 1e-3 * 0.02;
    const StepDepths found = fit_step_depths("pointing.csv", target, readings, first);
    EXPECT_NEAR(found.gain, -0.0004, 4.0 * found.gain_sigma);
    EXPECT_LT(found.gain_sigma, 2e-4);
    EXPECT_NEAR(found.tilt_x, 2e-3, 1e-4);
    EXPECT_NEAR(found.tilt_z, -1e-3, 2e-4);
    for (std::size_t i = 0; i < readings.size(); ++i) {
        const double height = target.steps[i % 3].height;
        const double y = -0.25 + 2e-3 * (readings[i].place.x + 0.3) - 1e-3 * (readings[i].place.z + 0.3) + height;
        EXPECT_NEAR(found.depths[i].y, y, 8e-6);
    }
}

TEST(StepDepths, RefusesWhatIsBlind) {
    Target target = stepped();
    auto readings = readings_of(target, 2e-6, 1);
    for (DepthReading& r : readings) {
        r.place.z = -0.3;
    }
    EXPECT_THROW(static_cast<void>(fit_step_depths("p.csv", target, readings, -0.25)), InputError);
    readings = readings_of(target, 2e-6, 1);
    readings[3].marker = 99;
    EXPECT_THROW(static_cast<void>(fit_step_depths("p.csv", target, readings, -0.25)), InputError);
}

}  // namespace
}  // namespace sc::host
