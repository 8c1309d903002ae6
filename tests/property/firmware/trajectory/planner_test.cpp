// SPDX-License-Identifier: Apache-2.0
// Random paths under random limits, judged on 1 ms samples by differences and distances alone.
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
    std::size_t below(std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_); }
    bool one_in(std::size_t n) { return below(n) == 0; }

private:
    std::mt19937_64 random_;
};

Spec random_spec(Source& from) {
    Spec spec;
    spec.speed = 0.2;
    spec.tolerance = 1e-5;
    const bool usual = from.one_in(3);
    if (!usual) {
        spec.speed = from.spread(1e-3, 2.0);
        spec.tolerance = from.one_in(5) ? 0.0 : from.spread(1e-6, 1e-3);
    }
    for (std::size_t k = 0; k < 3; ++k) {
        spec.limits.speed[k] = usual ? 0.2 : from.spread(1e-3, 2.0);
        spec.limits.acceleration[k] = usual ? 5.0 : from.spread(0.05, 50.0);
        spec.limits.jerk[k] = usual ? 200.0 : from.spread(1.0, 5000.0);
    }
    if (from.one_in(2)) {
        spec.limits.speed[3] = from.spread(1.0, 360.0);
        spec.limits.acceleration[3] = from.spread(10.0, 5000.0);
        spec.limits.jerk[3] = from.spread(100.0, 1e5);
    }
    return spec;
}

/// Chords of 0.01 µm to 500 mm; bends, zigzags, reversals, repeated points, near-collinear ones; rounded or not.
std::vector<Place> random_path(Source& from, const Spec& spec) {
    enum class Kind : std::uint8_t { bends, mixed_chords, reversals, collinear, repeated, spiral, zigzag, count };
    const auto kind = static_cast<Kind>(from.below(static_cast<std::size_t>(Kind::count)));
    const bool turns = spec.limits.speed[3] > 0.0;
    const std::size_t count = 2 + from.below(90);
    const double chord = from.spread(1e-8, 0.05);
    const double bend = from.spread(1e-4, 3.0);
    const double grid = from.one_in(2) ? 1e-7 : 0.0;
    double heading = from.between(0.0, 6.28);
    double climb = 0.0;
    std::vector<Place> points{{from.between(-0.3, 0.3), from.between(-0.3, 0.3), from.between(-0.3, 0.3), 0.0}};
    for (std::size_t i = 1; i < count; ++i) {
        Place p = points.back();
        double step = chord;
        switch (kind) {
            case Kind::mixed_chords: step = from.spread(1e-8, from.one_in(40) ? 0.5 : 0.01); [[fallthrough]];
            case Kind::bends:
                heading += from.between(-bend, bend);
                climb += 0.3 * from.between(-bend, bend);
                break;
            case Kind::reversals: heading += from.one_in(3) ? std::numbers::pi : 0.0; break;
            case Kind::collinear: heading += from.between(-1e-4, 1e-4); break;
            case Kind::repeated:
                step = from.one_in(3) ? 0.0 : chord;
                heading += from.between(-bend, bend);
                break;
            case Kind::spiral:
                heading += 0.2 * bend;
                climb = 0.1;
                break;
            case Kind::zigzag: heading += (i % 2 == 0 ? 1.0 : -1.0) * from.between(0.0, bend); break;
            case Kind::count: break;
        }
        p[0] += step * std::cos(heading) * std::cos(climb);
        p[1] += step * std::sin(heading) * std::cos(climb);
        p[2] += step * std::sin(climb);
        if (turns && from.one_in(2)) {
            p[3] += from.between(-1.0, 1.0) * from.spread(1e-5, 1.0);
        }
        if (turns && from.one_in(20)) {
            p = points.back();
            p[3] += from.between(-5.0, 5.0);
        }
        for (std::size_t k = 0; k < 3; ++k) {
            p[k] = std::clamp(grid > 0.0 ? std::round(p[k] / grid) * grid : p[k], -2.0, 2.0);
        }
        points.push_back(p);
    }
    return points;
}

double nearest(const Place& p, const std::vector<Place>& points) {
    double best = 1e30;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        best = std::min(best, to_segment(p, points[i], points[i + 1]));
    }
    return best;
}

class RandomPaths : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(RandomPaths, KeepEveryLimitOnEverySample) {
    constexpr std::uint64_t kPaths = SC_RANDOM_PATHS;
    for (std::uint64_t seed = GetParam() * kPaths; seed < (GetParam() + 1) * kPaths; ++seed) {
        SCOPED_TRACE(seed);
        Source from(seed);
        const Spec spec = random_spec(from);
        const std::vector<Place> points = random_path(from, spec);
        const Planned run = plan(spec, points, 1 + static_cast<std::uint32_t>(from.below(40)),
                                 1 + static_cast<std::uint32_t>(from.below(400)));
        if (!run.complete) {
            // Only paths whose points all merge into one are refused.
            for (const Place& p : points) {
                ASSERT_LE(to_segment(p, points[0], points[0]), 2e-4);
            }
            continue;
        }
        if (run.seconds > 300.0) {
            continue;  // would take too long to sample; shorter ones of the same kind are looked at
        }
        const std::vector<Place> samples = sample(run);
        const Shares most = shares(spec, samples);
        ASSERT_LE(most.path_speed, 1.005);
        ASSERT_LE(most.speed, 1.005);
        ASSERT_LE(most.acceleration, 1.005);
        ASSERT_LE(most.jerk, 1.005);
        const double tolerance = spec.tolerance * 1.001 + 2e-9;
        for (const Place& p : samples) {
            ASSERT_LE(nearest(p, points), tolerance);
        }
        const Steps step = steps(run);
        ASSERT_LE(step.place, 1e-10);  // degrees too
        // The last point may have merged into the one before it.
        ASSERT_LE(to_segment(samples.back(), points.back(), points.back()), 2.1e-6);
        std::uint32_t item = 0;
        for (const Piece& piece : run.pieces) {
            ASSERT_GT(piece.duration, 0.0);
            ASSERT_GE(piece.item, item);
            item = piece.item;
        }
        ASSERT_LT(item, points.size());
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomPaths, ::testing::Range<std::uint64_t>(0, 8));

}  // namespace
}  // namespace sc::trajectory::testing
