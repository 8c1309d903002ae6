// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/planner.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "tests/unit/firmware/trajectory/sampled.hpp"

namespace sc::trajectory::testing {
namespace {

Spec stage() {
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

Problem problem_of(const std::expected<void, Refusal>& result) { return result.error().problem; }

class PlannerTest : public ::testing::Test {
protected:
    Memory memory_;
    Planner planner_{{memory_.points, memory_.nodes, memory_.pieces}};
};

TEST_F(PlannerTest, RefusesBadLimits) {
    Spec spec = stage();
    spec.speed = 0.0;
    EXPECT_EQ(problem_of(planner_.open(spec)), Problem::bad_speed);
    spec = stage();
    spec.tolerance = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(problem_of(planner_.open(spec)), Problem::bad_tolerance);
    spec = stage();
    spec.limits.jerk[1] = -1.0;
    const auto refused = planner_.open(spec);
    EXPECT_EQ(problem_of(refused), Problem::bad_limit);
    EXPECT_EQ(refused.error().axis, 1);
    EXPECT_EQ(problem_of(planner_.add({}, 0)), Problem::not_open);
}

TEST_F(PlannerTest, RefusesBadPointsByNumberAndAxis) {
    ASSERT_TRUE(planner_.open(stage()));
    ASSERT_TRUE(planner_.add({0.0, 0.0, 0.0, 5.0}, 0));
    const auto not_finite = planner_.add({0.0, std::numeric_limits<double>::infinity(), 0.0, 5.0}, 1);
    EXPECT_EQ(problem_of(not_finite), Problem::bad_point);
    EXPECT_EQ(not_finite.error().point, 1U);
    EXPECT_EQ(not_finite.error().axis, 1);
    const auto blocked = planner_.add({0.0, 0.0, 0.0, 6.0}, 1);
    EXPECT_EQ(problem_of(blocked), Problem::blocked_axis);
    EXPECT_EQ(blocked.error().axis, 3);
    EXPECT_EQ(problem_of(planner_.finish()), Problem::too_short);
    EXPECT_TRUE(planner_.add({0.01, 0.0, 0.0, 5.0}, 1));
    EXPECT_TRUE(planner_.finish());
}

TEST_F(PlannerTest, TakesNoMorePointsThanThereIsRoomFor) {
    ASSERT_TRUE(planner_.open(stage()));
    std::uint32_t count = 0;
    while (planner_.wants_points()) {
        ASSERT_TRUE(planner_.add({1e-4 * count, 0.0, 0.0, 0.0}, count));
        ++count;
    }
    EXPECT_EQ(count, memory_.points.size());
    EXPECT_EQ(problem_of(planner_.add({1.0, 0.0, 0.0, 0.0}, count)), Problem::no_room);
}

TEST(Planner, PassesOneLineInClosedForm) {
    // 7 phases: 200 mm/s is reached in v/a + a/J = 65 ms over 6.5 mm; the rest at full speed.
    const Planned run = plan(stage(), {{0.0, 0.0, 0.0, 0.0}, {0.1, 0.0, 0.0, 0.0}});
    ASSERT_TRUE(run.complete);
    EXPECT_NEAR(run.seconds, 2 * 0.065 + (0.1 - 0.013) / 0.2, 1e-12);
    EXPECT_EQ(run.pieces.size(), 7U);
    EXPECT_EQ(run.pieces.back().place(run.pieces.back().duration)[0], 0.1);
}

TEST(Planner, OverlapsARightAngle) {
    // Two lines of 20 mm take 165 ms each. The corner may be moved out by a third of the tolerance, a little less for
    // these lines, so the overlap is near 2·(6 · 1.33 · tol / J)^(1/3) = 14.7 ms.
    const std::vector<Place> points{{0.0, 0.0, 0.0, 0.0}, {0.02, 0.0, 0.0, 0.0}, {0.02, 0.02, 0.0, 0.0}};
    const Planned run = plan(stage(), points);
    ASSERT_TRUE(run.complete);
    EXPECT_NEAR(2 * 0.165 - run.seconds, 0.0147, 1e-4);
    EXPECT_LE(deviation_in_order(sample(run, 1e-4), points, 1e-5), 1e-5);
}

TEST(Planner, StopsAtCornersWithoutTolerance) {
    Spec spec = stage();
    spec.tolerance = 0.0;
    const std::vector<Place> points{{0.0, 0.0, 0.0, 0.0}, {0.02, 0.0, 0.0, 0.0}, {0.02, 0.02, 0.0, 0.0}};
    const Planned run = plan(spec, points);
    ASSERT_TRUE(run.complete);
    EXPECT_NEAR(run.seconds, 2 * 0.165, 1e-12);
    EXPECT_LE(deviation_in_order(sample(run), points, 1e-9), 1e-12);
}

TEST(Planner, TurnsBackByOneHundredAndEightyDegrees) {
    const std::vector<Place> points{{0.0, 0.0, 0.0, 0.0}, {0.02, 0.0, 0.0, 0.0}, {0.005, 0.0, 0.0, 0.0}};
    const Planned run = plan(stage(), points);
    ASSERT_TRUE(run.complete);
    EXPECT_LE(shares(stage(), sample(run)).worst(), 1.005);
    EXPECT_LE(farthest_point(sample(run, 1e-4), points), 1.5e-5);
}

TEST(Planner, MovesTheTurntableByItsOwnLimits) {
    Spec spec = stage();
    spec.limits.speed[3] = 90.0;
    spec.limits.acceleration[3] = 600.0;
    spec.limits.jerk[3] = 12000.0;
    std::vector<Place> points;
    for (int i = 0; i <= 400; ++i) {
        const double t = i / 400.0;
        points.push_back({0.03 * std::sin(6.0 * t), 0.02 * t, 0.0, 60.0 * std::sin(3.0 * t)});
    }
    const Planned run = plan(spec, points);
    ASSERT_TRUE(run.complete);
    const Shares most = shares(spec, sample(run));
    EXPECT_LE(most.worst(), 1.005);
    EXPECT_GE(most.speed, 0.9);  // it is C that limits
}

TEST(Planner, DoesNotDependOnHowWorkIsInterleaved) {
    std::vector<Place> points;
    for (int i = 0; i < 1500; ++i) {
        const double t = 1e-4 * i;
        points.push_back({t, 2e-3 * std::sin(t / 3e-3) + (i % 300 < 5 ? 4e-5 * (i % 300) : 2e-4), 0.0, 0.0});
    }
    const Planned one = plan(stage(), points, 1, 7);
    const Planned other = plan(stage(), points, 977, 100000);
    ASSERT_TRUE(one.complete);
    ASSERT_TRUE(other.complete);
    ASSERT_EQ(one.pieces.size(), other.pieces.size());
    for (std::size_t i = 0; i < one.pieces.size(); ++i) {
        ASSERT_EQ(one.pieces[i].start, other.pieces[i].start) << i;
        ASSERT_EQ(one.pieces[i].duration, other.pieces[i].duration) << i;
        ASSERT_EQ(one.pieces[i].axis, other.pieces[i].axis) << i;
        ASSERT_EQ(one.pieces[i].distance, other.pieces[i].distance) << i;
        ASSERT_EQ(one.pieces[i].item, other.pieces[i].item) << i;
    }
}

TEST(Planner, SecondPathOfAPlannerEqualsTheFirst) {
    Memory memory;
    Planner planner({memory.points, memory.nodes, memory.pieces});
    const auto pass = [&](double size) {
        std::vector<Piece> pieces;
        EXPECT_TRUE(planner.open(stage()));
        for (std::uint32_t i = 0; i < 300; ++i) {
            const double t = 0.02 * i;
            EXPECT_TRUE(planner.add({size * std::cos(t), size * std::sin(t), 0.0, 0.0}, i));
        }
        EXPECT_TRUE(planner.finish());
        while (!planner.complete()) {
            planner.work(50);
            while (planner.ready() > 0) {
                pieces.push_back(planner.front());
                planner.pop();
            }
        }
        return pieces;
    };
    const std::vector<Piece> first = pass(0.01);
    const std::vector<Piece> between = pass(0.004);
    const std::vector<Piece> again = pass(0.01);
    EXPECT_NE(first.size(), between.size());
    ASSERT_EQ(first.size(), again.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
        ASSERT_EQ(first[i].axis, again[i].axis) << i;
    }
}

TEST(Planner, DistanceIsTheLengthOfThePathAsRun) {
    std::vector<Place> points;
    for (int i = 0; i <= 628; ++i) {
        points.push_back({0.01 * std::cos(0.01 * i), 0.01 * std::sin(0.01 * i), 0.0, 0.0});
    }
    const Planned run = plan(stage(), points);
    ASSERT_TRUE(run.complete);
    const std::vector<Place> samples = sample(run, 1e-5);
    double sum = 0.0;
    for (std::size_t i = 1; i < samples.size(); ++i) {
        sum += std::hypot(samples[i][0] - samples[i - 1][0], samples[i][1] - samples[i - 1][1]);
    }
    const Piece& last = run.pieces.back();
    EXPECT_NEAR(value(last.distance, last.duration), sum, 1e-9);
    std::uint32_t item = 0;
    for (const Piece& piece : run.pieces) {
        EXPECT_GE(piece.item, item);
        item = piece.item;
        EXPECT_LE(to_segment(piece.place(0.0), points[item], points[item + 1]), 1e-4);
    }
}

/// Mirrors that draw a circle of 0.2 mm on the way, again and again: bends so tight that a cell from or to rest leaves
/// them, and knots that are uneven in the curve's own parameter.
TEST(Planner, DrawsAWobbleWithoutStoppingInIt) {
    for (const double tolerance : {1e-6, 4.5e-6, 2e-5}) {
        Spec spec;
        spec.speed = 0.25;
        spec.tolerance = tolerance;
        for (std::size_t k = 0; k < 3; ++k) {
            spec.limits.speed[k] = 2.0;
            spec.limits.acceleration[k] = 8000.0;
            spec.limits.jerk[k] = 8e7;
        }
        std::vector<Place> points;
        double length = 0.0;
        for (int i = 0; i <= 3200; ++i) {
            const double turn = 2.0 * 3.14159265358979 / 32.0 * i;
            points.push_back({60e-6 / 32.0 * i + 1e-4 * std::cos(turn), 0.0, 1e-4 * std::sin(turn), 0.0});
            if (i > 0) {
                const Place& a = points[points.size() - 2];
                length += std::hypot(points.back()[0] - a[0], points.back()[2] - a[2]);
            }
        }
        const Planned run = plan(spec, points);
        ASSERT_TRUE(run.complete);
        EXPECT_EQ(run.counts.crawled, 0U) << tolerance;
        EXPECT_EQ(run.counts.stretched, 0U) << tolerance;
        EXPECT_LT(run.counts.passes, 3 * run.counts.plans + 3) << tolerance;
        EXPECT_LT(run.seconds, 1.03 * length / spec.speed) << tolerance;
    }
}

}  // namespace
}  // namespace sc::trajectory::testing
