// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "firmware/trajectory/planner.hpp"

/// Plans whole paths, and looks at the result only by its samples: differences of 1 kHz places, nearest distances to
/// the polyline. Shares nothing with the planner but the pieces.

namespace sc::trajectory::testing {

struct Planned {
    std::vector<Piece> pieces;
    WindowCounts counts;
    bool complete = false;
    double seconds = 0.0;
    std::uint64_t units = 0;  ///< of work
};

struct Memory {
    std::vector<Vertex> points{1024};
    std::vector<Node> nodes{256};
    std::vector<Piece> pieces{256};
};

/// Plans `points`; `chunk` is how many points are added before the planner works, `units` how much it then does, so
/// that different ways of interleaving can be compared.
inline Planned plan(const Spec& spec, const std::vector<Place>& points, std::uint32_t chunk = 1,
                    std::uint32_t units = 64, double window = 0.0, std::size_t nodes = 256) {
    Memory memory;
    memory.nodes.resize(nodes);
    Planner planner({memory.points, memory.nodes, memory.pieces});
    Planned run;
    if (!planner.open(spec)) {
        return run;
    }
    if (window > 0.0) {
        planner.set_window(window);
    }
    const auto drain = [&] {
        while (planner.ready() > 0) {
            run.pieces.push_back(planner.front());
            planner.pop();
        }
    };
    // A planner that neither works nor gives pieces nor takes points is stuck: `complete` stays false.
    std::uint32_t item = 0;
    for (const Place& point : points) {
        while (!planner.wants_points()) {
            const std::uint32_t used = planner.work(units);
            run.units += used;
            if (used == 0 && planner.ready() == 0) {
                return run;
            }
            drain();
        }
        if (!planner.add(point, item)) {
            return run;
        }
        ++item;
        if (item % chunk == 0) {
            run.units += planner.work(units);
            drain();
        }
    }
    if (!planner.finish()) {
        return run;
    }
    while (!planner.complete()) {
        const std::uint32_t used = planner.work(units);
        run.units += used;
        if (used == 0 && planner.ready() == 0) {
            return run;
        }
        drain();
    }
    drain();
    run.complete = true;
    run.counts = planner.counts();
    run.seconds = run.pieces.empty() ? 0.0 : run.pieces.back().start + run.pieces.back().duration;
    return run;
}

/// Places at 1 kHz from rest to rest, with rest before and behind.
inline std::vector<Place> sample(const Planned& run, double period = 1e-3) {
    std::vector<Place> samples(3, run.pieces.front().place(0.0));
    std::size_t i = 0;
    for (std::size_t n = 0;; ++n) {
        const double t = static_cast<double>(n) * period;
        while (i + 1 < run.pieces.size() && t >= run.pieces[i + 1].start) {
            ++i;
        }
        if (t > run.seconds) {
            break;
        }
        samples.push_back(run.pieces[i].place(t - run.pieces[i].start));
    }
    samples.insert(samples.end(), 4, run.pieces.back().place(run.pieces.back().duration));
    return samples;
}

/// Worst shares of the limits over all samples.
struct Shares {
    double path_speed = 0.0;
    double speed = 0.0;
    double acceleration = 0.0;
    double jerk = 0.0;
    [[nodiscard]] double worst() const { return std::max({path_speed, speed, acceleration, jerk}); }
};

inline Shares shares(const Spec& spec, const std::vector<Place>& samples, double period = 1e-3) {
    Shares found;
    // Rounding of a place far from the origin shows in its third difference.
    double farthest = 0.0;
    for (const Place& p : samples) {
        for (const double x : p) {
            farthest = std::max(farthest, std::abs(x));
        }
    }
    const double rounding = farthest * 0x1p-52;
    for (std::size_t i = 3; i < samples.size(); ++i) {
        double square = 0.0;
        for (std::size_t k = 0; k < kAxisCount; ++k) {
            const double a = samples[i][k];
            const double b = samples[i - 1][k];
            const double c = samples[i - 2][k];
            const double d = samples[i - 3][k];
            const double v = (a - b) / period;
            if (k < 3) {
                square += v * v;
            }
            const auto share = [](double value, double limit) {
                return limit > 0.0 ? std::abs(value) / limit : (value == 0.0 ? 0.0 : 1e9);
            };
            const double p2 = period * period;
            const auto off = [&](double difference, double noise) {
                return std::max(0.0, std::abs(difference) - noise * rounding);
            };
            found.speed = std::max(found.speed, share(off(a - b, 2) / period, spec.limits.speed[k]));
            found.acceleration =
                std::max(found.acceleration, share(off(a - 2 * b + c, 4) / p2, spec.limits.acceleration[k]));
            found.jerk =
                std::max(found.jerk, share(off(a - 3 * b + 3 * c - d, 8) / (p2 * period), spec.limits.jerk[k]));
        }
        found.path_speed = std::max(found.path_speed, std::sqrt(square) / spec.speed);
    }
    return found;
}

/// Distance from a place to the segment a–b over x, y, z.
inline double to_segment(const Place& p, const Place& a, const Place& b) {
    double along = 0.0;
    double square = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        along += (p[k] - a[k]) * (b[k] - a[k]);
        square += (b[k] - a[k]) * (b[k] - a[k]);
    }
    const double t = square > 0.0 ? std::clamp(along / square, 0.0, 1.0) : 0.0;
    double sum = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double off = p[k] - (a[k] + t * (b[k] - a[k]));
        sum += off * off;
    }
    return std::sqrt(sum);
}

/// Greatest distance of the samples from the polyline when they pass it in order: the path is followed by dynamic
/// programming over (sample, segment), so a shortcut to a later part of the path counts as a deviation.
inline double deviation_in_order(const std::vector<Place>& samples, const std::vector<Place>& points,
                                 double tolerance) {
    // Segments that a sample may be on, given that all before were within `tolerance` and in order.
    std::size_t low = 0;
    std::size_t high = 0;
    double worst = 0.0;
    const std::size_t segments = points.size() - 1;
    for (const Place& p : samples) {
        // Reachable: from `low` to `high`, and on from there over segments that stay near.
        std::size_t end = high;
        double best = 1e30;
        std::size_t first = segments;
        std::size_t last = low;
        for (std::size_t i = low; i < segments; ++i) {
            const double d = to_segment(p, points[i], points[i + 1]);
            best = std::min(best, d);
            if (d <= tolerance) {
                first = std::min(first, i);
                last = i;
            }
            double step = 0.0;
            for (std::size_t k = 0; k < 3; ++k) {
                step = std::max(step, std::abs(points[i + 1][k] - points[std::min(end + 1, segments)][k]));
            }
            if (i > end && step > 2e-3) {
                break;
            }
        }
        worst = std::max(worst, best);
        if (first < segments) {
            low = first;
            high = last;
        }
    }
    return worst;
}

/// Greatest distance of a point from the samples taken in order.
inline double farthest_point(const std::vector<Place>& samples, const std::vector<Place>& points) {
    std::size_t at = 0;
    double worst = 0.0;
    for (const Place& point : points) {
        double best = 1e30;
        std::size_t best_at = at;
        double away = 0.0;
        for (std::size_t i = at; i + 1 < samples.size(); ++i) {
            const double d = to_segment(point, samples[i], samples[i + 1]);
            if (d < best) {
                best = d;
                best_at = i;
                away = 0.0;
            } else {
                away = std::max(away, d - best);
            }
            if (best < 2e-5 && away > 1e-4) {
                break;
            }
        }
        worst = std::max(worst, best);
        at = best_at;
    }
    return worst;
}

/// Greatest step of place, speed and acceleration between one piece and the next, as shares of what would show.
struct Steps {
    double place = 0.0;
    double speed = 0.0;
    double acceleration = 0.0;
};
inline Steps steps(const Planned& run) {
    Steps found;
    for (std::size_t i = 0; i + 1 < run.pieces.size(); ++i) {
        const Piece& a = run.pieces[i];
        const Piece& b = run.pieces[i + 1];
        for (std::size_t k = 0; k < kAxisCount; ++k) {
            found.place = std::max(found.place, std::abs(value(a.axis[k], a.duration) - b.axis[k][0]));
            found.speed = std::max(found.speed, std::abs(rate(a.axis[k], a.duration) - b.axis[k][1]));
            found.acceleration =
                std::max(found.acceleration, std::abs(second_rate(a.axis[k], a.duration) - 2.0 * b.axis[k][2]));
        }
    }
    return found;
}

}  // namespace sc::trajectory::testing
