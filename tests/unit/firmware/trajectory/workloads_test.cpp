// SPDX-License-Identifier: Apache-2.0
// The asked figures of three workloads, judged on 1 ms samples by differences alone.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/firmware/trajectory/sampled.hpp"

namespace sc::trajectory::testing {
namespace {

Spec asked_limits() {
    Spec spec;
    spec.speed = 0.2;
    spec.tolerance = 1e-5;
    for (std::size_t k = 0; k < 3; ++k) {
        spec.limits.speed[k] = 0.2;
        spec.limits.acceleration[k] = 5.0;
        spec.limits.jerk[k] = 200.0;
    }
    return spec;
}

std::vector<Place> read_csv(const std::string& name) {
    std::ifstream file(std::string(SC_TEST_DATA) + "/motion/" + name);
    std::vector<Place> points;
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
        Place p{};
        if (std::sscanf(line.c_str(), "%lf,%lf,%lf", &p[0], &p[1], &p[2]) == 3) {
            points.push_back({p[0] * 1e-3, p[1] * 1e-3, p[2] * 1e-3, 0.0});
        }
    }
    return points;
}

void expect_within(const Spec& spec, const std::vector<Place>& points, const Planned& run) {
    ASSERT_TRUE(run.complete);
    const std::vector<Place> samples = sample(run);
    const Shares most = shares(spec, samples);
    EXPECT_LE(most.path_speed, 1.005);
    EXPECT_LE(most.speed, 1.005);
    EXPECT_LE(most.acceleration, 1.005);
    EXPECT_LE(most.jerk, 1.005);
    EXPECT_LE(deviation_in_order(samples, points, spec.tolerance), spec.tolerance);
    // A corner is cut by no more than √2 of the tolerance, and a bend by the tolerance.
    EXPECT_LE(farthest_point(samples, points), 1.5 * spec.tolerance);
    const Steps step = steps(run);
    EXPECT_LE(step.place, 1e-14);
    EXPECT_LE(step.speed, 1e-12);
    EXPECT_LE(step.acceleration, 1e-8);
    EXPECT_EQ(run.pieces.front().item, 0U);
}

TEST(Workloads, CornersTakeLessThanAsked) {
    const std::vector<Place> points = read_csv("b_corners.csv");
    ASSERT_EQ(points.size(), 501U);
    const Planned run = plan(asked_limits(), points);
    expect_within(asked_limits(), points, run);
    EXPECT_LE(run.seconds, 80.9);
    EXPECT_NEAR(run.seconds, 80.214, 0.001);
}

TEST(Workloads, MixedPathTakesLessThanAsked) {
    const std::vector<Place> points = read_csv("c_mixed.csv");
    ASSERT_EQ(points.size(), 4001U);
    const Planned run = plan(asked_limits(), points);
    expect_within(asked_limits(), points, run);
    EXPECT_LE(run.seconds, 17.6);
    EXPECT_EQ(run.counts.crawled, 0U);
}

TEST(Workloads, DenseRoundedLineTakesLessThanAsked) {
    const std::vector<Place> points = read_csv("a_dense.csv");
    ASSERT_EQ(points.size(), 20000U);
    const Planned run = plan(asked_limits(), points);
    expect_within(asked_limits(), points, run);
    EXPECT_LE(run.seconds, 6.9);
    EXPECT_EQ(run.counts.crawled, 0U);
}

/// Chords about `scale`, turns of up to `turn` at each vertex, about any axis.
std::vector<Place> walk(std::uint64_t seed, double scale, double turn) {
    std::mt19937_64 random(seed);
    const auto between = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
    };
    std::vector<Place> points{{0.0, 0.0, 0.0, 0.0}};
    std::array<double, 3> d{1.0, 0.0, 0.0};
    while (points.size() < 200) {
        std::array<double, 3> e{between(-1.0, 1.0), between(-1.0, 1.0), between(-1.0, 1.0)};
        const double along = e[0] * d[0] + e[1] * d[1] + e[2] * d[2];
        for (std::size_t k = 0; k < 3; ++k) {
            e[k] -= along * d[k];
        }
        const double across = std::hypot(e[0], e[1], e[2]);
        if (across < 1e-3) {
            continue;
        }
        const double angle = between(0.2, 1.0) * turn;
        const double chord = scale * std::exp(between(-1.0, 1.0));
        Place p = points.back();
        for (std::size_t k = 0; k < 3; ++k) {
            d[k] = std::cos(angle) * d[k] + std::sin(angle) * e[k] / across;
            p[k] += chord * d[k];
        }
        points.push_back(p);
    }
    return points;
}

TEST(Walks, AreHardlyEverCrawledAndPlannedFasterThanTheyAreRun) {
    std::uint64_t seed = 0;
    std::uint32_t crawled = 0;
    std::uint32_t cells = 0;
    for (const double scale : {3e-5, 1e-4, 3e-4, 1e-3, 4e-3}) {
        for (const double turn : {0.2, 0.4, 0.7}) {
            for (int i = 0; i < 4; ++i) {
                SCOPED_TRACE(++seed);
                const Planned run = plan(asked_limits(), walk(seed, scale, turn));
                ASSERT_TRUE(run.complete);
                EXPECT_LE(shares(asked_limits(), sample(run)).worst(), 1.005);
                crawled += run.counts.crawled;
                cells += run.counts.cells;
                // The controller grants 34 a millisecond: half of that may go into re-timing.
                EXPECT_LE(static_cast<double>(run.units), 17.0 * run.seconds * 1e3);
            }
        }
    }
    EXPECT_LE(1000 * crawled, cells);
}

TEST(Workloads, LookAheadOf256PointsIsAsGoodAsUnlimited) {
    const std::vector<Place> points = read_csv("a_dense.csv");
    const Planned near = plan(asked_limits(), points, 1, 64, 256 * 5e-5);
    const Planned far = plan(asked_limits(), points, 1, 64, 1e3, 8192);
    ASSERT_TRUE(near.complete);
    ASSERT_TRUE(far.complete);
    EXPECT_LE(near.seconds, 1.005 * far.seconds);
}

}  // namespace
}  // namespace sc::trajectory::testing
