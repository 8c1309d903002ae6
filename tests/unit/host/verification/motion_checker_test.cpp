// SPDX-License-Identifier: Apache-2.0
#include "host/verification/motion_checker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/formats/error.hpp"
#include "host/verification/motion_report.hpp"
#include "tests/unit/host/verification/motion_support.hpp"

namespace sc::host {
namespace {

using namespace test;

constexpr std::array<const char*, 4> kName{"x", "y", "z", "c"};
constexpr double kFive = 5e-3;

TEST(MotionChecker, PassesAMoveThatReachesEveryLimitOfEveryAxis) {
    const MotionLimits limits = default_motion_limits();
    for (std::size_t axis = 0; axis < 4; ++axis) {
        for (const double phase : {0.0, 0.3, 0.77}) {
            const MotionReport report =
                check_motion(sampled_axis(axis, move_of(limits.axis[axis], 1.0, 1.0, 1.0), phase), limits);
            EXPECT_TRUE(report.passed()) << kName[axis] << motion_text(report);
            for (std::size_t k = 0; k < 3; ++k) {
                EXPECT_NEAR(report.rows[axis].worst[k].ratio, 1.0, kFive) << kName[axis] << k;
                EXPECT_LE(report.rows[axis].worst[k].ratio, 1.0 + 1e-6) << "averages do not exceed what they are of";
            }
            const auto& worst = report.rows[axis].worst;
            EXPECT_EQ(report.max_limit_ratio(), std::max({worst[0].ratio, worst[1].ratio, worst[2].ratio}));
        }
    }
}

TEST(MotionChecker, RejectsOnePerCentTooMuchOfAnyQuantityOfAnyAxis) {
    const MotionLimits limits = default_motion_limits();
    constexpr std::array<Breach, 3> kBreach{Breach::speed, Breach::acceleration, Breach::jerk};
    for (std::size_t axis = 0; axis < 4; ++axis) {
        for (std::size_t broken = 0; broken < 3; ++broken) {
            std::array<double, 3> part{0.9, 0.9, 0.9};
            part[broken] = 1.01;
            const MotionReport report =
                check_motion(sampled_axis(axis, move_of(limits.axis[axis], part[0], part[1], part[2])), limits);
            EXPECT_TRUE(only(report, kBreach[broken], kName[axis])) << kName[axis] << broken << motion_text(report);
            EXPECT_NEAR(report.rows[axis].worst[broken].ratio, 1.01, kFive);
            EXPECT_EQ(report.first.front().limit, report.rows[axis].worst[broken].limit);
        }
    }
}

TEST(MotionChecker, JudgesAgainstTheLimitAllowedAndNoOther) {
    MotionLimits limits = default_motion_limits();
    const auto samples = sampled_axis(1, move_of(limits.axis[1], 0.9, 0.9, 1.01));
    limits.allow = 1.02;
    EXPECT_TRUE(check_motion(samples, limits).passed());
    limits.allow = 1.0;
    EXPECT_FALSE(check_motion(samples, limits).passed());
    EXPECT_TRUE(check_motion(sampled_axis(1, move_of(limits.axis[1], 1.0, 1.0, 1.0)), limits).passed())
        << "rounding to the grid is no breach";
}

TEST(MotionChecker, NamesTheTickOfTheWorst) {
    MotionLimits limits = default_motion_limits();
    limits.first_tick = 1000;
    auto samples = sampled_axis(0, move_of(limits.axis[0], 0.5, 0.5, 0.5));
    samples[40][0] += 1'000'000;  // 1 um: jerk of 3000 m/s3 two ticks later
    const MotionReport report = check_motion(samples, limits);
    EXPECT_TRUE(only(report, Breach::jerk, "x")) << motion_text(report);
    EXPECT_GE(report.rows[0].worst[2].tick, 1040);
    EXPECT_LE(report.rows[0].worst[2].tick, 1043);
    EXPECT_GT(report.rows[0].worst[2].ratio, 14.0);
    EXPECT_EQ(report.violations, 4U);
    EXPECT_EQ(report.first.size(), 1U) << "ticks in a row are one place";
}

TEST(MotionChecker, AgreesWithDifferencesOfRandomSamples) {
    std::mt19937_64 random(7);
    std::uniform_int_distribution<std::int64_t> step(-50'000, 50'000);
    MotionLimits limits = default_motion_limits();
    for (int run = 0; run < 200; ++run) {
        std::vector<AxisPositions> samples(50);
        for (std::size_t n = 4; n < 46; ++n) {
            for (std::size_t i = 0; i < 4; ++i) {
                samples[n][i] = step(random);
            }
        }
        const MotionReport report = check_motion(samples, limits);
        for (std::size_t i = 0; i < 4; ++i) {
            std::array<double, 3> largest{};
            std::vector<double> values;
            for (const AxisPositions& s : samples) {
                values.push_back(static_cast<double>(s[i]) / (i == 3 ? 1e9 : 1e12));
            }
            for (std::size_t k = 0; k < 3; ++k) {
                for (std::size_t n = values.size() - 1; n > 0; --n) {
                    values[n] = (values[n] - values[n - 1]) / kTick;
                    largest[k] = std::max(largest[k], std::abs(values[n]));
                }
                values[0] = 0.0;
                EXPECT_NEAR(report.rows[i].worst[k].value, largest[k], 1e-9 * largest[k]);
            }
        }
    }
}

TEST(MotionChecker, AMotionMustStartAndEndAtRest) {
    const MotionLimits limits = default_motion_limits();
    const auto whole = sampled_axis(2, move_of(limits.axis[2], 1.0, 1.0, 1.0));
    const std::vector<AxisPositions> tail(whole.begin() + 40, whole.end());
    MotionReport report = check_motion(tail, limits);
    EXPECT_TRUE(only(report, Breach::not_at_rest, "z")) << motion_text(report);
    EXPECT_EQ(report.first.front().tick, 0);
    const std::vector<AxisPositions> head(whole.begin(), whole.end() - 40);
    report = check_motion(head, limits);
    EXPECT_TRUE(only(report, Breach::not_at_rest, "z")) << motion_text(report);
    EXPECT_EQ(report.first.front().tick, static_cast<std::int64_t>(head.size()) - 1);
    // Without the ticks at rest before and after it is still at rest.
    const std::vector<AxisPositions> bare(whole.begin() + 3, whole.end() - 3);
    EXPECT_TRUE(check_motion(bare, limits).passed()) << motion_text(check_motion(bare, limits));
}

TEST(MotionChecker, AStepAtTheVeryEndIsSeen) {
    const MotionLimits limits = default_motion_limits();
    auto samples = sampled_axis(0, move_of(limits.axis[0], 1.0, 1.0, 1.0));
    samples.back()[0] += 30'000;  // 30 nm: less than an axis covers that comes to rest, but this one was at rest before
    EXPECT_TRUE(check_motion(samples, limits).passed()) << "within what jerk allows";
    samples.back()[0] += 10'000;
    EXPECT_FALSE(check_motion(samples, limits).passed());
}

TEST(MotionChecker, PathSpeedIsTheNormOfTheAxes) {
    MotionLimits limits = default_motion_limits();
    const SevenPhases move = move_of(limits.axis[0], 1.0, 1.0, 1.0);
    const auto diagonal = sampled(
        move.seconds(), [&](double t) { return std::array<double, 4>{0.6 * move.at(t), 0.8 * move.at(t), 0.0, 0.0}; });
    limits.path_speed = 0.2;
    MotionReport report = check_motion(diagonal, limits);
    EXPECT_TRUE(report.passed()) << motion_text(report);
    EXPECT_NEAR(report.rows[4].worst[0].value, 0.2, 1e-6);
    limits.path_speed = 0.2 / 1.01;
    report = check_motion(diagonal, limits);
    EXPECT_TRUE(only(report, Breach::speed, "path")) << motion_text(report);
    EXPECT_NEAR(report.rows[4].worst[0].ratio, 1.01, 1e-4);
}

TEST(MotionChecker, TravelIsKeptToTheMicrometre) {
    for (std::size_t axis = 0; axis < 4; ++axis) {
        MotionLimits limits = default_motion_limits();
        const SevenPhases move = move_of(limits.axis[axis], 1.0, 1.0, 1.0);
        const auto samples = sampled_axis(axis, move);
        limits.axis[axis].travel_min = 0.0;
        limits.axis[axis].travel_max = move.way;
        EXPECT_TRUE(check_motion(samples, limits).passed()) << kName[axis];
        limits.axis[axis].travel_max = move.way - 1e-6;
        EXPECT_TRUE(only(check_motion(samples, limits), Breach::travel, kName[axis]));
        limits.axis[axis].travel_max = 1.0 + move.way;
        limits.axis[axis].travel_min = 1e-6;
        EXPECT_TRUE(only(check_motion(samples, limits), Breach::travel, kName[axis]));
    }
}

TEST(MotionChecker, AKeepOutVolumeMayBeTouchedButNotEntered) {
    MotionLimits limits = default_motion_limits();
    const SevenPhases move = move_of(limits.axis[0], 1.0, 1.0, 1.0);
    const auto samples = sampled_axis(0, move);
    limits.keep_out = {{{move.way, -0.1, -0.1}, {move.way + 0.1, 0.1, 0.1}}};
    EXPECT_TRUE(check_motion(samples, limits).passed());
    limits.keep_out[0].min.x -= 1e-6;
    const MotionReport report = check_motion(samples, limits);
    EXPECT_TRUE(only(report, Breach::keep_out, "")) << motion_text(report);
    EXPECT_NEAR(report.first.front().value, 1e-6, 2e-12);
    // The motion slides along a face.
    limits.keep_out = {{{-0.1, 0.0, -0.1}, {0.1, 0.1, 0.1}}};
    EXPECT_TRUE(check_motion(samples, limits).passed());
    limits.keep_out[0].min.y = -1e-6;
    EXPECT_TRUE(only(check_motion(samples, limits), Breach::keep_out, ""));
}

TEST(MotionChecker, AKeepOutVolumeThatLiesBetweenTwoSamplesIsSeen) {
    MotionLimits limits = default_motion_limits();
    const SevenPhases move = move_of(limits.axis[0], 1.0, 1.0, 1.0);
    const auto samples = sampled_axis(0, move);
    const double a = static_cast<double>(samples[90][0]) / 1e12;
    const double b = static_cast<double>(samples[91][0]) / 1e12;
    limits.keep_out = {{{a + 0.4 * (b - a), -0.1, -0.1}, {a + 0.6 * (b - a), 0.1, 0.1}}};
    const MotionReport report = check_motion(samples, limits);
    EXPECT_TRUE(only(report, Breach::keep_out, ""));
    EXPECT_EQ(report.first.front().tick, 91);
}

TEST(MotionChecker, OneSampleIsAMotionAtRest) {
    const MotionReport report = check_motion(std::vector<AxisPositions>(1), default_motion_limits());
    EXPECT_TRUE(report.passed());
    EXPECT_EQ(report.ticks, 1);
    EXPECT_EQ(report.max_limit_ratio(), 0.0);
}

template <class Work>
std::string refusal(Work work) {
    try {
        work();
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TEST(MotionChecker, RefusesWhatCannotBeJudged) {
    const std::vector<AxisPositions> two(2);
    const MotionLimits good = default_motion_limits();
    EXPECT_NE(refusal([&] { (void)check_motion({}, good); }).find("no samples"), std::string::npos);
    for (const double bad :
         {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        MotionLimits limits = good;
        limits.axis[3].jerk = bad;
        EXPECT_NE(refusal([&] { (void)check_motion(two, limits); }).find("jerk limit of axis c"), std::string::npos);
        limits = good;
        limits.path_speed = bad;
        EXPECT_NE(refusal([&] { (void)check_motion(two, limits); }).find("path speed"), std::string::npos);
        const std::vector<Vec3> path{{0, 0, 0}, {1, 0, 0}};
        EXPECT_NE(refusal([&] { (void)check_motion(two, good, path, bad); }).find("tolerance"), std::string::npos);
        const std::vector<Vec3> no_place{{0, 0, 0}, {0, bad == -1.0 || bad == 0.0 ? 2e3 : bad, 0}};
        EXPECT_NE(refusal([&] { (void)check_motion(two, good, no_place, 1e-5); }).find("point 1"), std::string::npos);
    }
    MotionLimits limits = good;
    limits.allow = 0.99;
    EXPECT_NE(refusal([&] { (void)check_motion(two, limits); }).find("0.99"), std::string::npos);
    std::vector<AxisPositions> far(3);
    far[2][1] = std::numeric_limits<std::int64_t>::min();
    EXPECT_NE(refusal([&] { (void)check_motion(far, good); }).find("sample 2 of axis y"), std::string::npos);
    const std::vector<Vec3> point{{0, 0, 0}};
    EXPECT_NE(refusal([&] { (void)check_motion(two, good, point, 1e-5); }).find("too few"), std::string::npos);
}

TEST(MotionReport, SaysTheSameAsTextAndJson) {
    const MotionLimits limits = default_motion_limits();
    const MotionReport bad = check_motion(sampled_axis(3, move_of(limits.axis[3], 0.9, 0.9, 1.01)), limits);
    const std::string text = motion_text(bad);
    EXPECT_NE(text.find("jerk of c 1818"), std::string::npos) << text;
    EXPECT_NE(text.find("BROKEN"), std::string::npos);
    const auto json = motion_json(bad);
    EXPECT_EQ(json["passed"], false);
    EXPECT_EQ(json["violations"][0]["rule"], "jerk");
    EXPECT_EQ(json["violations"][0]["axis"], "c");
    EXPECT_TRUE(json["path"].is_null());
    EXPECT_NEAR(json["axes"]["c"]["jerk"]["ratio"].get<double>(), 1.01, kFive);
    EXPECT_TRUE(json["axes"]["path"]["speed"]["ratio"].is_null()) << "there is no limit";
    const MotionReport good = check_motion(sampled_axis(3, move_of(limits.axis[3], 1.0, 1.0, 1.0)), limits);
    EXPECT_NE(motion_text(good).find("passed"), std::string::npos);
    EXPECT_EQ(motion_json(good)["passed"], true);
}

}  // namespace
}  // namespace sc::host
