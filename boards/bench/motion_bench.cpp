// SPDX-License-Identifier: Apache-2.0
#include "boards/bench/motion_bench.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace sc::bench {
namespace {

using trajectory::Piece;
using trajectory::Place;
using trajectory::Planner;
using trajectory::Refusal;
using trajectory::Spec;

constexpr std::uint32_t kUnitsPerPoint = 64;
constexpr double kPeriod = 1e-3;

struct Plan {
    std::vector<Piece> pieces;
    std::uint32_t cells = 0;
    double us = 0.0;
    double worst_us = 0.0;
    [[nodiscard]] double seconds() const { return pieces.back().start + pieces.back().duration; }
};

double us_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

/// `window` 0: the planner's own look-ahead.
std::expected<Plan, Refusal> plan(const Spec& spec, const std::vector<Place>& points, double window,
                                  std::size_t node_count) {
    std::vector<trajectory::Vertex> vertices(1024);
    std::vector<trajectory::Node> nodes(node_count);
    std::vector<Piece> ring(1024);
    Planner planner({vertices, nodes, ring});
    Plan made;
    made.pieces.reserve(points.size() * 8);
    const auto drain = [&] {
        while (planner.ready() > 0) {
            made.pieces.push_back(planner.front());
            planner.pop();
        }
    };
    const auto must_move = [&](std::uint32_t used) {
        if (used == 0 && planner.ready() == 0) {
            throw std::logic_error("the planner neither works nor waits for anything");
        }
    };
    const auto start = std::chrono::steady_clock::now();
    if (const auto opened = planner.open(spec); !opened) {
        return std::unexpected(opened.error());
    }
    if (window > 0.0) {
        planner.set_window(window);
    }
    std::uint32_t item = 0;
    for (const Place& point : points) {
        const auto insert = std::chrono::steady_clock::now();
        while (!planner.wants_points()) {
            must_move(planner.work(kUnitsPerPoint));
            drain();
        }
        if (const auto added = planner.add(point, item); !added) {
            return std::unexpected(added.error());
        }
        ++item;
        planner.work(kUnitsPerPoint);
        drain();
        made.worst_us = std::max(made.worst_us, us_since(insert));
    }
    if (const auto finished = planner.finish(); !finished) {
        return std::unexpected(finished.error());
    }
    while (!planner.complete()) {
        must_move(planner.work(kUnitsPerPoint));
        drain();
    }
    drain();
    made.us = us_since(start);
    made.cells = planner.counts().cells;
    return made;
}

std::vector<Place> sample(const Plan& made) {
    std::vector<Place> samples(3, made.pieces.front().place(0.0));
    std::size_t i = 0;
    for (std::size_t n = 0; static_cast<double>(n) * kPeriod <= made.seconds(); ++n) {
        const double t = static_cast<double>(n) * kPeriod;
        while (i + 1 < made.pieces.size() && t >= made.pieces[i + 1].start) {
            ++i;
        }
        samples.push_back(made.pieces[i].place(t - made.pieces[i].start));
    }
    samples.insert(samples.end(), 4, made.pieces.back().place(made.pieces.back().duration));
    return samples;
}

double limit_ratio(const Spec& spec, const std::vector<Place>& samples) {
    double worst = 0.0;
    for (std::size_t i = 3; i < samples.size(); ++i) {
        double square = 0.0;
        for (std::size_t k = 0; k < kAxisCount; ++k) {
            const double a = samples[i][k];
            const double b = samples[i - 1][k];
            const double c = samples[i - 2][k];
            const double d = samples[i - 3][k];
            if (k < 3) {
                square += (a - b) * (a - b);
            }
            if (spec.limits.speed[k] > 0.0) {
                worst = std::max(worst, std::abs(a - b) / (kPeriod * spec.limits.speed[k]));
                worst = std::max(worst, std::abs(a - 2 * b + c) / (kPeriod * kPeriod * spec.limits.acceleration[k]));
                worst = std::max(worst,
                                 std::abs(a - 3 * b + 3 * c - d) / (kPeriod * kPeriod * kPeriod * spec.limits.jerk[k]));
            }
        }
        worst = std::max(worst, std::sqrt(square) / (kPeriod * spec.speed));
    }
    return worst;
}

/// Foot of a place on a segment: distance from it, and how far along.
struct Foot {
    double distance = 1e30;
    double s = 0.0;
};

Foot foot_on(const Place& p, const Place& a, const Place& b, double s) {
    double dot = 0.0;
    double square = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        dot += (p[k] - a[k]) * (b[k] - a[k]);
        square += (b[k] - a[k]) * (b[k] - a[k]);
    }
    const double t = square > 0.0 ? std::clamp(dot / square, 0.0, 1.0) : 0.0;
    double sum = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double off = p[k] - (a[k] + t * (b[k] - a[k]));
        sum += off * off;
    }
    return {std::sqrt(sum), s + t * std::sqrt(square)};
}

/// Worst distance when the samples pass the polyline in order: each foot is looked for near the last one only.
double deviation(const Spec& spec, const std::vector<Place>& points, const std::vector<Place>& samples) {
    std::vector<double> length(points.size(), 0.0);
    for (std::size_t i = 1; i < points.size(); ++i) {
        length[i] = length[i - 1] + foot_on(points[i - 1], points[i], points[i], 0.0).distance;
    }
    const double back = 20.0 * spec.tolerance + 1e-5;
    const double ahead = 3.0 * spec.speed * kPeriod + back;
    double at = 0.0;
    double worst = 0.0;
    std::size_t first = 0;
    for (const Place& p : samples) {
        while (first + 2 < points.size() && length[first + 1] < at - back) {
            ++first;
        }
        while (first > 0 && length[first] > at - back) {
            --first;
        }
        Foot best;
        for (std::size_t i = first; i + 1 < points.size() && length[i] <= at + ahead; ++i) {
            const Foot foot = foot_on(p, points[i], points[i + 1], length[i]);
            // Of feet about as near the one furthest on, so that a way back over itself is not lost.
            if (foot.distance < best.distance + 0.05 * spec.tolerance) {
                best = {std::min(foot.distance, best.distance), foot.s};
            }
        }
        worst = std::max(worst, best.distance);
        at = best.s;
    }
    return worst;
}

constexpr std::size_t kNodes = 512;

}  // namespace

std::expected<MotionFigures, Refusal> measure(const Spec& spec, const std::vector<Place>& points, int repeats) {
    MotionFigures figures;
    figures.points = points.size();
    for (int i = 0; i < std::max(repeats, 1); ++i) {
        const auto made = plan(spec, points, 0.0, kNodes);
        if (!made) {
            return std::unexpected(made.error());
        }
        const double us = made->us / static_cast<double>(points.size());
        if (i == 0) {
            figures.samples = sample(*made);
            figures.seconds = made->seconds();
            figures.limit_ratio = limit_ratio(spec, figures.samples);
            figures.deviation = deviation(spec, points, figures.samples);
            figures.pieces = made->pieces.size();
        }
        if (i == 0 || us < figures.us_per_point) {
            figures.us_per_point = us;
            figures.worst_insert_us = made->worst_us;
        }
    }
    return figures;
}

std::expected<double, Refusal> horizon_ratio(const Spec& spec, const std::vector<Place>& points) {
    double length = 0.0;
    for (std::size_t i = 1; i < points.size(); ++i) {
        length += foot_on(points[i - 1], points[i], points[i], 0.0).distance;
    }
    const auto near = plan(spec, points, 256.0 * length / static_cast<double>(points.size() - 1), kNodes);
    if (!near) {
        return std::unexpected(near.error());
    }
    const auto far = plan(spec, points, 1e6, std::bit_ceil(std::size_t{2} * near->cells + 1024));
    if (!far) {
        return std::unexpected(far.error());
    }
    return near->seconds() / far->seconds();
}

}  // namespace sc::bench
