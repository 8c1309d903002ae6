// SPDX-License-Identifier: Apache-2.0
// Random paths of lines and arcs under random limits, judged on 1 ms samples by differences and by the distance from
// the true lines and arcs.
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/firmware/trajectory/sampled.hpp"

namespace sc::trajectory::testing {
namespace {

class Source {
public:
    explicit Source(std::uint64_t seed) : random_(seed) {}
    double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
    /// Evenly over the orders of magnitude.
    double spread(double low, double high) { return low * std::exp(between(0.0, 1.0) * std::log(high / low)); }
    bool one_in(int n) { return std::uniform_int_distribution<int>(1, n)(random_) == 1; }

private:
    std::mt19937_64 random_;
};

struct Vector {
    double x = 0.0;
    double y = 0.0;
    double z = 0.0;
};
Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vector operator*(double k, const Vector& a) { return {k * a.x, k * a.y, k * a.z}; }
double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double length(const Vector& a) { return std::sqrt(dot(a, a)); }
Vector vector(const Place& p) { return {p[0], p[1], p[2]}; }

/// A line, or an arc over `sweep` from `from`, turning towards `ahead`.
struct Stretch {
    Place from{};
    Place to{};
    Vector centre;
    Vector out;    ///< of length 1, from the centre to `from`
    Vector ahead;  ///< of length 1
    double radius = 0.0;
    double sweep = 0.0;

    [[nodiscard]] Place at(double angle) const {
        const Vector p = centre + radius * (std::cos(angle) * out + std::sin(angle) * ahead);
        return {p.x, p.y, p.z, 0.0};
    }
    [[nodiscard]] double distance(const Place& p) const {
        if (!(sweep > 0.0)) {
            return to_segment(p, from, to);
        }
        const Vector r = vector(p) - centre;
        const double x = dot(r, out);
        const double y = dot(r, ahead);
        double angle = std::atan2(y, x);
        angle += angle < 0.0 ? 2.0 * std::numbers::pi : 0.0;
        if (angle > sweep) {
            return std::min(length(vector(p) - vector(from)), length(vector(p) - vector(to)));
        }
        const double above = length(r - x * out - y * ahead);
        return std::hypot(std::hypot(x, y) - radius, above);
    }
};

Spec random_spec(Source& from) {
    Spec spec;
    spec.speed = from.spread(1e-2, 1.0);
    spec.tolerance = from.spread(1e-6, 2e-4);
    for (std::size_t k = 0; k < 3; ++k) {
        spec.limits.speed[k] = from.spread(1e-2, 1.0);
        spec.limits.acceleration[k] = from.spread(0.5, 50.0);
        spec.limits.jerk[k] = from.spread(10.0, 5000.0);
    }
    return spec;
}

Vector random_direction(Source& from) {
    const Vector v{from.between(-1.0, 1.0), from.between(-1.0, 1.0), from.between(-1.0, 1.0) + 1e-3};
    return (1.0 / length(v)) * v;
}

/// An arc that goes on in the direction `ahead`, which it leaves as the one at its end.
Stretch random_arc(Source& from, const Place& start, Vector& ahead) {
    Stretch made;
    made.from = start;
    made.radius = from.spread(2e-4, 0.05);
    made.sweep = from.between(0.05, 6.0);
    const Vector any = random_direction(from);
    const Vector across = any - dot(any, ahead) * ahead;
    made.out = (1.0 / length(across)) * across;
    made.ahead = ahead;
    made.centre = vector(start) - made.radius * made.out;
    made.to = made.at(made.sweep);
    ahead = std::cos(made.sweep) * made.ahead - std::sin(made.sweep) * made.out;
    return made;
}

class RandomArcs : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(RandomArcs, StayWithinToleranceAndLimits) {
    constexpr std::uint64_t kPaths = SC_RANDOM_PATHS / 2 + 1;
    for (std::uint64_t seed = GetParam() * kPaths; seed < (GetParam() + 1) * kPaths; ++seed) {
        SCOPED_TRACE(seed);
        Source from(seed);
        const Spec spec = random_spec(from);
        Memory memory;
        Planner planner({memory.points, memory.nodes, memory.pieces});
        ASSERT_TRUE(planner.open(spec));
        Planned run;
        const std::uint32_t units = 1 + static_cast<std::uint32_t>(from.between(0.0, 100.0));
        const auto work = [&] {
            const std::uint32_t used = planner.work(units);
            const bool any = planner.ready() > 0;
            while (planner.ready() > 0) {
                run.pieces.push_back(planner.front());
                planner.pop();
            }
            return used > 0 || any;
        };
        Place at{from.between(-0.1, 0.1), from.between(-0.1, 0.1), from.between(-0.1, 0.1), 0.0};
        ASSERT_TRUE(planner.add(at, 0));
        std::vector<Stretch> path;
        Vector ahead = random_direction(from);
        for (std::uint32_t item = 1; item <= 4; ++item) {
            while (!planner.wants_points()) {
                ASSERT_TRUE(work());
            }
            if (from.one_in(3)) {
                ahead = random_direction(from);  // a corner
            }
            if (from.one_in(3)) {
                Stretch line;
                line.from = at;
                const Vector end = vector(at) + from.spread(1e-5, 0.05) * ahead;
                line.to = {end.x, end.y, end.z, 0.0};
                ASSERT_TRUE(planner.add(line.to, item));
                path.push_back(line);
            } else {
                const Stretch arc = random_arc(from, at, ahead);
                // What is refused changes nothing.
                ASSERT_FALSE(planner.add_arc(arc.from, arc.to, item));
                ASSERT_TRUE(planner.add_arc(arc.at(arc.sweep * from.between(0.3, 0.7)), arc.to, item));
                path.push_back(arc);
            }
            at = path.back().to;
        }
        ASSERT_TRUE(planner.finish());
        while (!planner.complete()) {
            ASSERT_TRUE(work());
        }
        run.seconds = run.pieces.back().start + run.pieces.back().duration;
        const std::vector<Place> samples = sample(run);
        const Shares most = shares(spec, samples);
        ASSERT_LE(most.path_speed, 1.005);
        ASSERT_LE(most.speed, 1.005);
        ASSERT_LE(most.acceleration, 1.005);
        ASSERT_LE(most.jerk, 1.005);
        for (const Place& p : samples) {
            double best = 1e30;
            for (const Stretch& stretch : path) {
                best = std::min(best, stretch.distance(p));
            }
            ASSERT_LE(best, spec.tolerance * 1.001 + 2e-9);
        }
        ASSERT_LE(to_segment(samples.back(), at, at), 2.1e-6);
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomArcs, ::testing::Range<std::uint64_t>(0, 4));

}  // namespace
}  // namespace sc::trajectory::testing
