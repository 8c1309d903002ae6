// SPDX-License-Identifier: Apache-2.0
// Arcs judged against the true circle: deviation, limits and time on 1 kHz samples.
#include "firmware/trajectory/arc.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/firmware/trajectory/sampled.hpp"

namespace sc::trajectory::testing {
namespace {

Spec usual(double tolerance = 1e-5) {
    Spec spec;
    spec.speed = 0.2;
    spec.tolerance = tolerance;
    for (std::size_t k = 0; k < 3; ++k) {
        spec.limits.speed[k] = 0.2;
        spec.limits.acceleration[k] = 5.0;
        spec.limits.jerk[k] = 200.0;
    }
    return spec;
}

double distance(const Place& a, const Place& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

/// A circle in space.
struct Circle {
    Place centre{};
    Place a{};  ///< of length 1, and perpendicular to b
    Place b{};
    double radius = 0.0;

    [[nodiscard]] Place at(double angle) const {
        Place p = centre;
        for (std::size_t k = 0; k < 3; ++k) {
            p[k] += radius * (std::cos(angle) * a[k] + std::sin(angle) * b[k]);
        }
        return p;
    }
    [[nodiscard]] double off(const Place& p) const {
        double x = 0.0;
        double y = 0.0;
        for (std::size_t k = 0; k < 3; ++k) {
            x += (p[k] - centre[k]) * a[k];
            y += (p[k] - centre[k]) * b[k];
        }
        double above = 0.0;
        for (std::size_t k = 0; k < 3; ++k) {
            above = std::hypot(above, p[k] - centre[k] - x * a[k] - y * b[k]);
        }
        return std::hypot(std::hypot(x, y) - radius, above);
    }
};

Circle flat(double radius) { return {{0.05, -0.02, 0.01, 0.0}, {1.0, 0.0, 0.0, 0.0}, {0.0, 1.0, 0.0, 0.0}, radius}; }

/// A path of points and arcs.
class Path {
public:
    explicit Path(const Spec& spec, std::uint32_t units = 7) : units_(units) { opened_ = bool(planner_.open(spec)); }
    void line(const Place& to) {
        make_room();
        ASSERT_TRUE(planner_.add(to, item_++));
    }
    void arc(const Place& via, const Place& to) {
        make_room();
        ASSERT_TRUE(planner_.add_arc(via, to, item_++));
    }
    Planned run() {
        EXPECT_TRUE(opened_);
        EXPECT_TRUE(planner_.finish());
        while (!planner_.complete() && step()) {
        }
        run_.complete = planner_.complete();
        run_.seconds = run_.pieces.empty() ? 0.0 : run_.pieces.back().start + run_.pieces.back().duration;
        run_.counts = planner_.counts();
        return run_;
    }

private:
    bool step() {
        const std::uint32_t used = planner_.work(units_);
        const bool any = planner_.ready() > 0;
        while (planner_.ready() > 0) {
            run_.pieces.push_back(planner_.front());
            planner_.pop();
        }
        return used > 0 || any;
    }
    void make_room() {
        while (!planner_.wants_points() && step()) {
        }
    }

    Memory memory_;
    Planner planner_{{memory_.points, memory_.nodes, memory_.pieces}};
    Planned run_;
    std::uint32_t item_ = 0;
    std::uint32_t units_;
    bool opened_ = false;
};

void expect_limits(const Spec& spec, const std::vector<Place>& samples) {
    const Shares most = shares(spec, samples);
    EXPECT_LE(most.path_speed, 1.005);
    EXPECT_LE(most.speed, 1.005);
    EXPECT_LE(most.acceleration, 1.005);
    EXPECT_LE(most.jerk, 1.005);
}

TEST(Arc, PointsAreOnTheCircleAndChordsWithinTheSagitta) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    for (int n = 0; n < 1000; ++n) {
        Circle circle;
        circle.radius = std::pow(10.0, -4.0 + 3.0 * std::abs(any(random)));
        circle.centre = {any(random), any(random), any(random), 0.0};
        const double tilt = any(random);
        circle.a = {std::cos(tilt), 0.0, std::sin(tilt), 0.0};
        circle.b = {-std::sin(tilt) * 0.6, 0.8, std::cos(tilt) * 0.6, 0.0};
        const double start = 3.0 * any(random);
        const double sweep = 0.05 + 6.1 * std::abs(any(random));
        Place from = circle.at(start);
        Place to = circle.at(start + sweep);
        from[3] = 1.0;
        to[3] = 3.0;
        const double sagitta = 1e-7;
        Arc arc;
        ASSERT_EQ(arc.begin(from, circle.at(start + 0.5 * sweep), to, sagitta, 1e-9), Arc::Kind::arc);
        const std::uint32_t parts = arc.left();
        Place last = from;
        double way = 0.0;
        for (std::uint32_t i = 1; arc.left() > 0; ++i) {
            const Place p = arc.next();
            ASSERT_LE(circle.off(p), 1e-12);
            Place middle{};
            for (std::size_t k = 0; k < 3; ++k) {
                middle[k] = 0.5 * (p[k] + last[k]);
            }
            ASSERT_LE(circle.off(middle), sagitta + 1e-12);
            ASSERT_NEAR(p[3], 1.0 + 2.0 * i / parts, 1e-12);
            way += distance(p, last);
            last = p;
        }
        ASSERT_EQ(last, to);
        ASSERT_NEAR(way, circle.radius * sweep, 0.02 * circle.radius * sweep);
    }
}

TEST(Arc, KindsThatAreNoArc) {
    Arc arc;
    const Place a{0.0, 0.0, 0.0, 0.0};
    const Place b{1.0, 0.0, 0.0, 0.0};
    EXPECT_EQ(arc.begin(a, {0.5, 1e-9, 0.0, 0.0}, b, 1e-8, 1e-9), Arc::Kind::line);
    EXPECT_EQ(arc.left(), 1U);
    EXPECT_EQ(arc.next(), b);
    EXPECT_EQ(arc.begin(a, {2.0, 0.0, 0.0, 0.0}, b, 1e-8, 1e-9), Arc::Kind::no_plane);
    EXPECT_EQ(arc.begin(a, b, a, 1e-8, 1e-9), Arc::Kind::no_plane);
    EXPECT_EQ(arc.begin(a, {0.5, 1e-3, 0.0, 0.0}, b, 1e-8, 1e-9), Arc::Kind::too_wide);
    EXPECT_EQ(arc.begin(a, {1e-10, 1e-10, 0.0, 0.0}, {0.0, 2e-10, 0.0, 0.0}, 1e-12, 1e-9), Arc::Kind::line);
}

TEST(ArcPath, QuarterCirclesStayWithinTheToleranceOfTheTrueArc) {
    for (const double radius : {2e-5, 1e-4, 1e-3, 1e-2, 0.1}) {
        for (const double tolerance : {1e-6, 1e-5, 1e-4}) {
            SCOPED_TRACE(radius);
            SCOPED_TRACE(tolerance);
            const Spec spec = usual(tolerance);
            const Circle circle = flat(radius);
            Path path(spec);
            path.line(circle.at(0.0));
            path.arc(circle.at(0.25 * std::numbers::pi), circle.at(0.5 * std::numbers::pi));
            const Planned run = path.run();
            ASSERT_TRUE(run.complete);
            const std::vector<Place> samples = sample(run);
            expect_limits(spec, samples);
            for (const Place& p : samples) {
                ASSERT_LE(circle.off(p), tolerance);
            }
            EXPECT_LE(distance(samples.back(), circle.at(0.5 * std::numbers::pi)), 2.1e-6);
        }
    }
}

TEST(ArcPath, WholeCirclesTakeLittleMoreThanTheBound) {
    for (const double radius : {2e-3, 1e-2, 5e-2}) {
        SCOPED_TRACE(radius);
        const Spec spec = usual();
        Circle circle = flat(radius);
        circle.b = {0.0, 0.6, 0.8, 0.0};
        Path path(spec);
        path.line(circle.at(0.0));
        path.arc(circle.at(0.5 * std::numbers::pi), circle.at(std::numbers::pi));
        path.arc(circle.at(1.5 * std::numbers::pi), circle.at(2.0 * std::numbers::pi));
        const Planned run = path.run();
        ASSERT_TRUE(run.complete);
        const std::vector<Place> samples = sample(run);
        expect_limits(spec, samples);
        double way = 0.0;
        for (std::size_t i = 0; i < samples.size(); ++i) {
            ASSERT_LE(circle.off(samples[i]), spec.tolerance);
            way += i > 0 ? distance(samples[i], samples[i - 1]) : 0.0;
        }
        const double length = 2.0 * std::numbers::pi * radius;
        EXPECT_NEAR(way, length, 2.0 * std::numbers::pi * spec.tolerance);
        EXPECT_EQ(run.counts.crawled, 0U);
        // At an even speed the axis x has acceleration v²/R and jerk v³/R² at their worst; a start and a stop at half
        // the acceleration besides.
        const double speed = std::min({0.2, std::sqrt(5.0 * radius), std::cbrt(200.0 * radius * radius)});
        EXPECT_GE(run.seconds, length / speed);
        EXPECT_LE(run.seconds, 1.02 * length / speed + speed / 2.5 + 5.0 / 200.0);
    }
}

TEST(ArcPath, GoesOnFromALineAndTurnsC) {
    Spec spec = usual();
    spec.limits.speed[3] = 90.0;
    spec.limits.acceleration[3] = 500.0;
    spec.limits.jerk[3] = 10000.0;
    const Circle circle = flat(0.01);
    Path path(spec);
    Place start = circle.at(0.0);
    start[1] -= 0.02;
    path.line(start);
    path.line(circle.at(0.0));
    Place end = circle.at(std::numbers::pi);
    end[3] = 5.0;
    path.arc(circle.at(1.0), end);
    const Planned run = path.run();
    ASSERT_TRUE(run.complete);
    EXPECT_NEAR(sample(run).back()[3], 5.0, 1e-9);
    std::uint32_t item = 0;
    for (const Piece& piece : run.pieces) {
        ASSERT_GE(piece.item, item);
        ASSERT_LE(piece.item, 2U);
        item = piece.item;
        const Place p = piece.place(0.0);
        // The item of an arc is passed at its end.
        if (p[1] > circle.centre[1] + 1e-4) {
            ASSERT_EQ(piece.item, 1U);
        }
    }
    expect_limits(spec, sample(run));
    // A tangent is no corner: the line runs into the arc without a stop.
    const double alone = [&] {
        Path arc(spec);
        arc.line(circle.at(0.0));
        arc.arc(circle.at(1.0), end);
        return arc.run().seconds;
    }();
    EXPECT_LT(run.seconds, alone + 0.02 / 0.1);
}

TEST(ArcPath, IsTheSameHoweverTheWorkIsCut) {
    const Circle circle = flat(0.02);
    std::vector<Planned> runs;
    for (const std::uint32_t units : {1U, 7U, 5000U}) {
        Path path(usual(), units);
        path.line(circle.at(0.0));
        path.arc(circle.at(1.0), circle.at(2.0));
        path.line(circle.centre);
        path.arc(circle.at(4.0), circle.at(3.0));
        runs.push_back(path.run());
        ASSERT_TRUE(runs.back().complete);
        ASSERT_EQ(runs.back().pieces.size(), runs[0].pieces.size());
        for (std::size_t i = 0; i < runs[0].pieces.size(); ++i) {
            ASSERT_EQ(runs.back().pieces[i].axis, runs[0].pieces[i].axis);
            ASSERT_EQ(runs.back().pieces[i].item, runs[0].pieces[i].item);
        }
    }
}

TEST(ArcPath, RefusalsNameThePoint) {
    Memory memory;
    Planner planner({memory.points, memory.nodes, memory.pieces});
    const auto problem = [](const std::expected<void, Refusal>& result) {
        return result ? Problem::not_open : result.error().problem;
    };
    const Place a{0.0, 0.0, 0.0, 0.0};
    const Place b{0.01, 0.0, 0.0, 0.0};
    ASSERT_TRUE(planner.open(usual()));
    EXPECT_EQ(problem(planner.add_arc(a, b, 0)), Problem::no_arc_here);
    ASSERT_TRUE(planner.add(a, 0));
    const auto refused = planner.add_arc({0.02, 0.0, 0.0, 0.0}, b, 1);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().problem, Problem::bad_arc);
    EXPECT_EQ(refused.error().point, 1U);
    EXPECT_EQ(problem(planner.add_arc({0.0, std::nan(""), 0.0, 0.0}, b, 1)), Problem::bad_point);
    EXPECT_EQ(problem(planner.add_arc({0.0, 1e5, 0.0, 0.0}, b, 1)), Problem::bad_point);
    EXPECT_EQ(problem(planner.add_arc({0.005, 0.001, 0.0, 0.0}, {0.01, 0.0, 0.0, 1.0}, 1)), Problem::blocked_axis);
    ASSERT_TRUE(planner.add_arc({0.005, 0.005, 0.0, 0.0}, b, 1));
    EXPECT_FALSE(planner.wants_points());
    EXPECT_EQ(problem(planner.add(a, 2)), Problem::no_room);
    Spec spec = usual();
    spec.tolerance = 1e-8;
    ASSERT_TRUE(planner.open(spec));
    ASSERT_TRUE(planner.add(a, 0));
    EXPECT_EQ(problem(planner.add_arc({0.005, 0.005, 0.0, 0.0}, b, 1)), Problem::no_arc_here);
}

TEST(ArcShape, NamesEveryPlaceWhereAnAxisTurnsBackAndTheDirectionsAtTheEnds) {
    std::mt19937_64 random(11);
    std::normal_distribution<double> normal;
    for (int n = 0; n < 300; ++n) {
        Circle circle;
        circle.radius = 0.05;
        for (std::size_t k = 0; k < 3; ++k) {
            circle.centre[k] = 0.1 * normal(random);
            circle.a[k] = normal(random);
            circle.b[k] = normal(random);
        }
        const double a = distance(circle.a, {});
        for (double& x : circle.a) {
            x /= a;
        }
        const double ab = circle.a[0] * circle.b[0] + circle.a[1] * circle.b[1] + circle.a[2] * circle.b[2];
        for (std::size_t k = 0; k < 3; ++k) {
            circle.b[k] -= ab * circle.a[k];
        }
        const double b = distance(circle.b, {});
        for (double& x : circle.b) {
            x /= b;
        }
        const double turn = 0.1 + 6.0 * std::abs(std::sin(n));
        const ArcShape shape = arc_shape(circle.at(0.0), circle.at(0.6 * turn), circle.at(turn));
        const auto direction = [&](double angle) {
            Place way{};
            for (std::size_t k = 0; k < 3; ++k) {
                way[k] = -std::sin(angle) * circle.a[k] + std::cos(angle) * circle.b[k];
            }
            return way;
        };
        EXPECT_LT(distance(shape.leaves, direction(0.0)), 1e-9);
        EXPECT_LT(distance(shape.arrives, direction(turn)), 1e-9);
        // The box of the ends and the turns is that of the arc.
        for (std::size_t k = 0; k < 3; ++k) {
            double least = std::min(circle.at(0.0)[k], circle.at(turn)[k]);
            double most = std::max(circle.at(0.0)[k], circle.at(turn)[k]);
            for (std::uint32_t i = 0; i < shape.turn_count; ++i) {
                EXPECT_LT(circle.off(shape.turns[i]), 1e-12);
                least = std::min(least, shape.turns[i][k]);
                most = std::max(most, shape.turns[i][k]);
            }
            double true_least = 1e9;
            double true_most = -1e9;
            for (int i = 0; i <= 20'000; ++i) {
                const double p = circle.at(turn * i / 20'000)[k];
                true_least = std::min(true_least, p);
                true_most = std::max(true_most, p);
            }
            EXPECT_NEAR(least, true_least, 1e-9);
            EXPECT_NEAR(most, true_most, 1e-9);
        }
    }
    const ArcShape line = arc_shape({}, {0.01, 0.0, 0.0, 0.0}, {0.03, 0.0, 0.0, 0.0});
    EXPECT_EQ(line.turn_count, 0U);
    EXPECT_EQ(line.leaves[0], 1.0);
    EXPECT_EQ(line.arrives[0], 1.0);
}

TEST(ArcPath, AnArcOfManyMorePointsThanTheMemoryHolds) {
    const Spec spec = usual(2e-7);
    const Circle circle = flat(0.03);
    Path path(spec);
    path.line(circle.at(0.0));
    path.arc(circle.at(1.0), circle.at(2.0));
    const Planned run = path.run();
    ASSERT_TRUE(run.complete);
    for (const Place& p : sample(run)) {
        ASSERT_LE(circle.off(p), spec.tolerance + 1e-9);
    }
}

}  // namespace
}  // namespace sc::trajectory::testing
