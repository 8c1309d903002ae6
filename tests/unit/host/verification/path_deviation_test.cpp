// SPDX-License-Identifier: Apache-2.0
#include "host/verification/path_deviation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"
#include "host/verification/motion_report.hpp"
#include "tests/unit/host/verification/motion_support.hpp"

namespace sc::host {
namespace {

using namespace test;

constexpr double kTolerance = 10e-6;
constexpr PathTolerance kUsual{kTolerance, kTolerance* std::numbers::sqrt2};
constexpr double kPm = 1e-12;

std::vector<Vec3> in_mm(const std::vector<Vec3>& points) {
    std::vector<Vec3> metres;
    for (const Vec3& p : points) {
        metres.push_back(1e-3 * p);
    }
    return metres;
}

AxisPositions sample_of(const Vec3& metres) {
    return {std::llround(metres.x * 1e12), std::llround(metres.y * 1e12), std::llround(metres.z * 1e12), 0};
}

/// Samples along a polyline at equal steps (metres), its vertices left out, its ends in.
std::vector<AxisPositions> along(const std::vector<Vec3>& path, double step) {
    std::vector<AxisPositions> samples{sample_of(path.front())};
    double rest = step;
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
        const double length = norm(path[i + 1] - path[i]);
        while (rest < length) {
            samples.push_back(sample_of(path[i] + (rest / length) * (path[i + 1] - path[i])));
            rest += step;
        }
        rest -= length;
    }
    samples.push_back(sample_of(path.back()));
    return samples;
}

/// Smallest distance to any segment, metres: each sample is at least as far from its place.
double nearest(const AxisPositions& sample, const std::vector<Vec3>& path) {
    const Vec3 p{1e-12 * static_cast<double>(sample[0]), 1e-12 * static_cast<double>(sample[1]),
                 1e-12 * static_cast<double>(sample[2])};
    double least = 1e300;
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
        const Vec3 way = path[i + 1] - path[i];
        const double square = dot(way, way);
        const double part = square > 0.0 ? std::clamp(dot(p - path[i], way) / square, 0.0, 1.0) : 0.0;
        least = std::min(least, norm(p - path[i] - part * way));
    }
    return least;
}

/// X first, Y begins `overlap` seconds before X ends: the corner is cut. The middle of the overlap is a sample.
std::vector<AxisPositions> corner(double overlap) {
    const SevenPhases move{0.05, 0.2, 5.0, 200.0};
    const double middle = move.seconds() - 0.5 * overlap;
    const double start = move.seconds() - overlap;
    const double phase = middle / kTick - std::floor(middle / kTick);
    return sampled(
        start + move.seconds(),
        [&](double t) { return std::array<double, 4>{move.at(t), move.at(std::max(0.0, t - start)), 0.0, 0.0}; },
        phase);
}
const std::vector<Vec3> kCorner = in_mm({{0, 0, 0}, {50, 0, 0}, {50, 50, 0}});
/// Overlap whose deviation is d: at its middle both axes are J (overlap/2)³/6 from the corner.
double overlap_of(double d) { return 2.0 * std::cbrt(6.0 * d / 200.0); }

TEST(PathDeviation, ACornerOverlapDeviatesAsCalculated) {
    for (const double d : {1e-6, 5e-6, 10e-6}) {
        const auto samples = corner(overlap_of(d));
        const PathDeviation found = path_deviation(samples, kCorner, {d, d * std::numbers::sqrt2});
        EXPECT_TRUE(found.followed) << d;
        EXPECT_NEAR(found.deviation, d, 2.0 * kPm);
        EXPECT_EQ(found.vertex, 1U);
        EXPECT_LE(found.vertex_miss, d * std::numbers::sqrt2);
        EXPECT_GE(found.vertex_miss, d * std::numbers::sqrt2 - 0.3e-6)
            << "what bulges between two samples is taken off";
        EXPECT_LE(found.start_gap, kPm);
        EXPECT_LE(found.end_gap, kPm);
    }
    const MotionReport report = check_motion(corner(overlap_of(10e-6)), default_motion_limits(), kCorner, kTolerance);
    EXPECT_TRUE(report.passed()) << motion_text(report);
}

TEST(PathDeviation, OnePerCentTooMuchIsRejected) {
    const MotionReport report =
        check_motion(corner(overlap_of(1.01 * kTolerance)), default_motion_limits(), kCorner, kTolerance);
    EXPECT_TRUE(only(report, Breach::deviation, "")) << motion_text(report);
    EXPECT_NEAR(report.deviation->deviation, 1.01 * kTolerance, 2.0 * kPm);
    EXPECT_EQ(report.first.front().tick, static_cast<std::int64_t>(report.deviation->sample));
    EXPECT_FALSE(report.deviation->followed);
    EXPECT_TRUE(report.deviation->matched);
}

TEST(PathDeviation, ABumpOnAStraightLineIsFoundWhereItIs) {
    const SevenPhases move{0.05, 0.2, 5.0, 200.0};
    const auto bump = [&](double height) {
        return sampled(move.seconds(), [&, height](double t) {
            const double x = move.at(t);
            const double s = std::sin(std::numbers::pi * x / move.way);
            return std::array<double, 4>{x, 0.6 * height * s * s, -0.8 * height * s * s, 0.0};
        });
    };
    const std::vector<Vec3> line = in_mm({{0, 0, 0}, {50, 0, 0}});
    MotionReport report = check_motion(bump(kTolerance), default_motion_limits(), line, kTolerance);
    EXPECT_TRUE(report.passed()) << motion_text(report);
    EXPECT_NEAR(report.deviation->deviation, kTolerance, 1e-9);
    report = check_motion(bump(1.01 * kTolerance), default_motion_limits(), line, kTolerance);
    EXPECT_TRUE(only(report, Breach::deviation, "")) << motion_text(report);
    EXPECT_NEAR(report.deviation->deviation, 1.01 * kTolerance, 1e-9);
    EXPECT_NEAR(static_cast<double>(report.deviation->sample), 1e3 * move.seconds() / 2.0 + 3.0, 2.0);
}

TEST(PathDeviation, APathCutShortOrOverrunIsFound) {
    const std::vector<Vec3> path = in_mm({{0, 0, 0}, {10, 0, 0}, {10, 10, 0}});
    const auto whole = along(path, 7e-6);
    EXPECT_TRUE(path_deviation(whole, path, kUsual).followed);
    auto samples = whole;
    samples.resize(samples.size() - 10);
    PathDeviation found = path_deviation(samples, path, kUsual);
    EXPECT_FALSE(found.followed);
    EXPECT_NEAR(found.end_gap, 66.5e-6, 3.5e-6);
    samples.resize(samples.size() / 2);
    found = path_deviation(samples, path, kUsual);
    EXPECT_FALSE(found.followed);
    EXPECT_FALSE(found.matched);
    EXPECT_EQ(found.lost_sample, samples.size() - 1);
    EXPECT_GT(found.end_gap, 9e-3);
    samples = whole;
    samples.push_back(sample_of({0.010, 0.010'011, 0.0}));
    found = path_deviation(samples, path, kUsual);
    EXPECT_FALSE(found.followed);
    EXPECT_NEAR(found.deviation, 11e-6, 1e-9);
    samples.back()[1] -= 1'000'000;
    EXPECT_TRUE(path_deviation(samples, path, kUsual).followed) << "the end may be missed by the tolerance";
    samples = whole;
    samples.erase(samples.begin(), samples.begin() + 2);
    found = path_deviation(samples, path, kUsual);
    EXPECT_FALSE(found.followed);
    EXPECT_NEAR(found.start_gap, 14e-6, 1e-9);
    const MotionReport report = check_motion(samples, default_motion_limits(), path, kTolerance);
    EXPECT_EQ(std::ranges::count(report.first, Breach::path_end, &Violation::breach), 1);
}

TEST(PathDeviation, ASpikeLeftOutIsFoundThoughEverySampleIsOnThePath) {
    // Out by `spike` and back on the same line; the motion drives past.
    for (const double spike : {0.05, 0.4, 5.0}) {
        const std::vector<Vec3> path = in_mm({{0, 0, 0}, {10, 0, 0}, {10, spike, 0}, {10, 0, 0}, {20, 0, 0}});
        EXPECT_TRUE(path_deviation(along(path, 0.01e-3), path, kUsual).followed) << spike;
        const auto past = along({path.front(), path.back()}, 0.01e-3);
        const PathDeviation found = path_deviation(past, path, kUsual);
        EXPECT_FALSE(found.followed) << spike;
        if (found.matched) {
            EXPECT_EQ(found.vertex, 2U);
            EXPECT_GT(found.vertex_miss, 0.7 * spike * 1e-3);
            EXPECT_TRUE(std::ranges::any_of(check_motion(past, default_motion_limits(), path, kTolerance).first,
                                            [](const Violation& v) { return v.breach == Breach::vertex_skipped; }));
        } else {
            EXPECT_LE(found.lost_vertex, 1U);
        }
    }
}

TEST(PathDeviation, OrderCounts) {
    const std::vector<Vec3> path = in_mm({{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}, {0, 0, 0}});
    const auto samples = along(path, 0.1e-3);
    EXPECT_TRUE(path_deviation(samples, path, kUsual).followed);
    const std::vector<AxisPositions> backwards(samples.rbegin(), samples.rend());
    EXPECT_FALSE(path_deviation(backwards, path, kUsual).followed) << "the same places, the other way round";
    // A line that is to be scribed three times, and was once.
    const std::vector<Vec3> thrice = in_mm({{0, 0, 0}, {10, 0, 0}, {0, 0, 0}, {10, 0, 0}});
    EXPECT_TRUE(path_deviation(along(thrice, 0.1e-3), thrice, kUsual).followed);
    EXPECT_FALSE(path_deviation(along({thrice[0], thrice[1]}, 0.1e-3), thrice, kUsual).followed);
    // Going back further than the tolerance on the way.
    std::vector<AxisPositions> hesitant = along({thrice[0], thrice[1]}, 0.1e-3);
    std::swap(hesitant[40], hesitant[41]);
    EXPECT_FALSE(path_deviation(hesitant, std::vector{thrice[0], thrice[1]}, kUsual).followed);
    // Within it.
    hesitant = along({thrice[0], thrice[1]}, 0.015e-3);
    std::swap(hesitant[40], hesitant[41]);
    EXPECT_TRUE(path_deviation(hesitant, std::vector{thrice[0], thrice[1]}, kUsual).followed);
}

TEST(PathDeviation, HatchLinesCloserThanTheToleranceDoNotConfuse) {
    std::vector<Vec3> path;
    for (int i = 0; i < 40; ++i) {
        const double y = 0.004 * i;  // mm
        path.push_back({i % 2 == 0 ? 0.0 : 5.0, y, 0.0});
        path.push_back({i % 2 == 0 ? 5.0 : 0.0, y, 0.0});
    }
    path = in_mm(path);
    const auto samples = along(path, 7e-6);
    const PathDeviation found = path_deviation(samples, path, kUsual);
    EXPECT_TRUE(found.followed);
    EXPECT_LE(found.deviation, 4e-6) << "the corners between two lines are cut";
    auto without = path;
    without.erase(without.begin() + 20, without.begin() + 24);  // a line there and back
    EXPECT_FALSE(path_deviation(along(without, 7e-6), path, kUsual).followed);
}

TEST(PathDeviation, RepeatedPointsAndDwellsAreFine) {
    const std::vector<Vec3> path =
        in_mm({{0, 0, 0}, {0, 0, 0}, {0.00001, 0, 0}, {10, 0, 0}, {10, 0, 0}, {10, 0, 0}, {10, 10, 0}, {10, 10, 0}});
    auto samples = along(path, 0.1e-3);
    samples.insert(samples.begin() + 50, 100'000, samples[50]);
    const PathDeviation found = path_deviation(samples, path, kUsual);
    EXPECT_TRUE(found.followed);
    EXPECT_LE(found.deviation, 2 * kPm);
    EXPECT_EQ(found.of_sample.size(), samples.size());
    EXPECT_TRUE(std::ranges::none_of(found.of_sample, [](float d) { return std::isnan(d); }));
    // A path shorter than its tolerance may be stood still on, one longer may not.
    const std::vector<AxisPositions> still(5);
    EXPECT_TRUE(path_deviation(still, in_mm({{0, 0, 0}, {0.005, 0, 0}, {0, 0.003, 0}}), kUsual).followed);
    EXPECT_FALSE(path_deviation(still, in_mm({{0, 0, 0}, {0.02, 0, 0}, {0, 0.003, 0}}), kUsual).followed);
}

/// A random walk with chords from 0.01 µm to 20 mm.
std::vector<Vec3> random_path(std::mt19937_64& random) {
    std::uniform_real_distribution<double> exponent(-8.0, -1.7);
    std::normal_distribution<double> normal;
    std::vector<Vec3> path{{0, 0, 0}};
    const double scale = exponent(random);
    for (int i = 0; i < 30; ++i) {
        const Vec3 way{normal(random), normal(random), normal(random)};
        const double chord = std::pow(10.0, 0.5 * (scale + exponent(random)));
        path.push_back(path.back() + (chord / norm(way)) * way);
    }
    return path;
}

TEST(PathDeviation, RandomPathsAreFollowedWithTheirNoiseAndNoMore) {
    std::mt19937_64 random(11);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> part(0.0, 1.0);
    int lost = 0;
    for (int run = 0; run < 400; ++run) {
        const std::vector<Vec3> path = random_path(random);
        double length = 0.0;
        for (std::size_t i = 0; i + 1 < path.size(); ++i) {
            length += norm(path[i + 1] - path[i]);
        }
        const double noise = 8e-6 * part(random);
        auto samples = along(path, std::max(length / 500.0, 1e-9));
        for (AxisPositions& sample : samples) {
            Vec3 off{normal(random), normal(random), normal(random)};
            off = (noise * part(random) / norm(off)) * off;
            for (std::size_t i = 0; i < 3; ++i) {
                sample[i] += std::llround(1e12 * off[i]);
            }
        }
        // Vertices lie between samples, so they are only as well covered as samples are dense.
        const PathTolerance wide{kTolerance, kTolerance + length / 500.0};
        const PathDeviation found = path_deviation(samples, path, wide);
        ASSERT_TRUE(found.followed) << run;
        EXPECT_LE(found.deviation, 1.002 * noise + 4.0 * kPm) << run;
        double largest = 0.0;
        for (std::size_t n = 0; n < samples.size(); ++n) {
            const double least = nearest(samples[n], path);
            largest = std::max(largest, least);
            ASSERT_GE(static_cast<double>(found.of_sample[n]), least * (1.0 - 1e-6) - 2.0 * kPm) << run << " " << n;
        }
        EXPECT_GE(found.deviation, largest - 2.0 * kPm);
        // One sample thrown off by more than the tolerance from all of the path is found in any of them.
        const auto victim = static_cast<std::size_t>(part(random) * static_cast<double>(samples.size() - 1));
        samples[victim][1] += std::llround(1e12 * 0.1);
        if (nearest(samples[victim], path) > 1.001 * kTolerance) {
            EXPECT_FALSE(path_deviation(samples, path, wide).followed) << run;
            ++lost;
        }
    }
    EXPECT_GT(lost, 390);
}

TEST(PathDeviation, AMotionMayReturnOnlyWhenToldSo) {
    const std::vector<Vec3> path = in_mm({{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {20, 10, 0}});
    // To 5 mm before the end, back to 2 mm after the start, and on to the end.
    std::vector<Vec3> way{path[0], path[1], path[2], {0.015, 0.010, 0}, path[2], path[1], {0.002, 0, 0}};
    way.insert(way.end(), path.begin() + 1, path.end());
    auto samples = along(way, 7e-6);
    PathTolerance tolerance = kUsual;
    EXPECT_FALSE(path_deviation(samples, path, tolerance).followed);
    tolerance.may_return = true;
    PathDeviation found = path_deviation(samples, path, tolerance);
    EXPECT_TRUE(found.followed);
    EXPECT_LE(found.deviation, 5e-6) << "the corners are cut between two samples";
    EXPECT_LE(found.vertex_miss, kUsual.cover);
    // All the rest is held to as before.
    samples[500][2] += 10'100'000;
    found = path_deviation(samples, path, tolerance);
    EXPECT_FALSE(found.followed);
    EXPECT_EQ(found.sample, 500U);
    EXPECT_NEAR(found.deviation, 10.1e-6, 1e-9);
    samples = along(way, 7e-6);
    samples.resize(samples.size() - 10);
    EXPECT_FALSE(path_deviation(samples, path, tolerance).followed) << "cut short";
    const std::vector<Vec3> spiked = in_mm({{0, 0, 0}, {10, 0, 0}, {10, 0, 0.3}, {10, 0, 0}, {10, 10, 0}, {20, 10, 0}});
    EXPECT_FALSE(path_deviation(along(way, 7e-6), spiked, tolerance).followed) << "left out";
    const auto forwards = along(path, 7e-6);
    EXPECT_TRUE(path_deviation(forwards, path, tolerance).followed);
    EXPECT_FALSE(
        path_deviation(std::vector<AxisPositions>(forwards.rbegin(), forwards.rend()), path, tolerance).followed);
}

TEST(PathDeviation, CostsStepsInProportion) {
    // A dense line of 20 000 points and 100 000 samples: the time is printed, not judged.
    std::vector<Vec3> path;
    for (int i = 0; i < 20'000; ++i) {
        const double s = 50e-6 * i;
        path.push_back({0.01 * std::sin(s / 0.02), 0.01 * std::cos(s / 0.02), 0.1 * s});
    }
    const auto samples = along(path, 5e-6);
    ASSERT_GT(samples.size(), 90'000U);
    const auto start = std::chrono::steady_clock::now();
    const PathDeviation found = path_deviation(samples, path, kUsual);
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    EXPECT_TRUE(found.followed);
    RecordProperty("seconds", std::to_string(spent.count()));
    std::printf("%zu samples, %zu points: %.3f s\n", samples.size(), path.size(), spent.count());
}

TEST(PathDeviation, RefusesAPathThatTakesTooMuchMemory) {
    std::vector<Vec3> path;
    for (int i = 0; i < 20'000; ++i) {
        path.push_back({1e-10 * i, 0.0, 0.0});
    }
    std::vector<AxisPositions> samples;
    for (int i = 0; i <= 20'000; ++i) {
        samples.push_back({100 * i, 0, 0, 0});
    }
    EXPECT_THROW((void)path_deviation(samples, path, kUsual), InputError);
    // With a tolerance that fits, what does not follow is found, though looser ones would not fit.
    samples.back()[1] = 50'000'000;
    const PathDeviation found = path_deviation(samples, path, {0.02e-6, 0.03e-6});
    EXPECT_FALSE(found.followed);
    EXPECT_FALSE(found.matched);
    EXPECT_EQ(found.lost_sample, samples.size() - 1);
}

}  // namespace
}  // namespace sc::host
