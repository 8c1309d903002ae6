// SPDX-License-Identifier: Apache-2.0
#include "host/verification/motion_svg.hpp"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "tests/unit/host/verification/motion_support.hpp"

namespace sc::host {
namespace {

using namespace test;

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) {
        ++found;
    }
    return found;
}

MotionTrace trace_of(std::vector<AxisPositions> samples) {
    MotionTrace trace{.file = {}, .samples = std::move(samples), .led = {}, .machine = {}, .has_c = true};
    trace.led.assign(trace.samples.size(), 1);
    return trace;
}

TEST(MotionSvg, MarksWhatIsBrokenAndNothingElse) {
    const MotionLimits limits = default_motion_limits();
    for (const double jerk : {1.0, 1.01}) {
        const MotionTrace trace = trace_of(sampled_axis(1, move_of(limits.axis[1], 0.9, 0.9, jerk)));
        const std::string svg = motion_svg("a <trace>", trace, limits, check_motion(trace.samples, limits));
        EXPECT_EQ(count(svg, "class=\"brokendot\"") > 0, jerk > 1.0);
        EXPECT_NE(svg.find("a &lt;trace&gt;"), std::string::npos);
        EXPECT_NE(svg.find("jerk, m/s³"), std::string::npos);
        EXPECT_EQ(svg.find("jerk of C"), std::string::npos) << "C stands";
        EXPECT_EQ(svg.find("deviation"), std::string::npos) << "no path is given";
        EXPECT_EQ(count(svg, "class=\"limit\""), 3U * 3U) << "two lines and a legend a panel";
        EXPECT_EQ(svg.find("nan"), std::string::npos);
    }
}

TEST(MotionSvg, DrawsCAndDeviationWhenThereAreSome) {
    MotionLimits limits = default_motion_limits();
    limits.path_speed = 0.25;
    const SevenPhases move{0.05, 0.2, 5.0, 200.0};
    const MotionTrace trace = trace_of(sampled(
        move.seconds(), [&](double t) { return std::array<double, 4>{move.at(t), 0.0, 0.0, 10.0 * move.at(t)}; }));
    const std::vector<Vec3> path{{0, 0, 0}, {0.05, 0, 0}};
    const std::string svg = motion_svg("t", trace, limits, check_motion(trace.samples, limits, path, 1e-5));
    EXPECT_NE(svg.find("speed of C, degrees/s"), std::string::npos);
    EXPECT_NE(svg.find("deviation from the path, µm"), std::string::npos);
    EXPECT_EQ(count(svg, "class=\"pathlimit\""), 2U);
    EXPECT_EQ(count(svg, "class=\"limit\""), 6U * 3U + 2U);
    limits.axis[1].jerk = 150.0;
    const std::string other = motion_svg("t", trace, limits, check_motion(trace.samples, limits, path, 1e-5));
    EXPECT_EQ(count(other, "class=\"limit ly\""), 3U) << "axes with limits of their own";
    EXPECT_EQ(count(other, "class=\"limit\""), 5U * 3U + 2U);
}

TEST(MotionSvg, KeepsEveryPeakOfALongTraceInLessThanAMegabyte) {
    const MotionLimits limits = default_motion_limits();
    std::vector<AxisPositions> samples;
    for (int n = 0; n < 100'000; ++n) {
        const auto wave = [n](double period, double height) {
            return std::llround(height * std::sin(n / period) * std::sin(n / period));
        };
        samples.push_back({wave(31.0, 1e9), wave(37.0, 1e9), wave(41.0, 1e9), wave(43.0, 1e8)});
    }
    samples[77'777][2] += 100'000'000;
    const MotionTrace trace = trace_of(std::move(samples));
    const std::vector<Vec3> path{{0, 0, 0}, {0.001, 0.001, 0.001}};
    const MotionReport report = check_motion(trace.samples, limits, path, 1e-5);
    const std::string svg = motion_svg("long", trace, limits, report);
    EXPECT_LT(svg.size(), 1'000'000U);
    EXPECT_GT(svg.size(), 100'000U);
    EXPECT_GT(count(svg, "class=\"brokendot\""), 0U);
    // The one sample that is off by 0.1 mm makes a speed of 0.1 m/s; without it, 0.033 m/s: the scale shows it.
    EXPECT_NE(svg.find("tick 77779: jerk of z"), std::string::npos);
}

TEST(MotionSvg, LeavesOutWhatTheDrivesLead) {
    const MotionLimits limits = default_motion_limits();
    MotionTrace trace = trace_of(std::vector<AxisPositions>(200));
    for (std::size_t n = 0; n < 100; ++n) {
        trace.led[n] = 0;
        trace.samples[n][0] = static_cast<std::int64_t>(n % 7) * 1'000'000'000;
    }
    const std::string svg = motion_svg("t", trace, limits, MotionReport{});
    EXPECT_EQ(svg.find('V', svg.find("</style>")), std::string::npos) << "at rest, nothing rises";
}

}  // namespace
}  // namespace sc::host
