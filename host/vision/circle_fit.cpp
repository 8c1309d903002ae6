// SPDX-License-Identifier: Apache-2.0
#include "host/vision/circle_fit.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sc::host {

namespace {

constexpr std::size_t kFewest = 5;
constexpr int kNewtonRounds = 10;
constexpr int kRobustRounds = 5;
constexpr double kOutlier = 3.0;
constexpr double kMadToSigma = 1.4826;

using Points = std::vector<std::array<double, 2>>;

/// Solves the symmetric 3×3 system by Cramer's rule; false if it is singular.
bool solve3(const std::array<std::array<double, 3>, 3>& a, const std::array<double, 3>& b, std::array<double, 3>& x) {
    const auto det = [](const std::array<std::array<double, 3>, 3>& m) {
        return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    };
    const double d = det(a);
    const double size = a[0][0] * a[1][1] * a[2][2];
    if (!(std::abs(d) > 1e-12 * std::abs(size))) {
        return false;
    }
    for (std::size_t i = 0; i < 3; ++i) {
        auto m = a;
        for (std::size_t k = 0; k < 3; ++k) {
            m[k][i] = b[k];
        }
        x[i] = det(m) / d;
    }
    return true;
}

/// Algebraic circle about the points' mean.
std::optional<Circle> algebraic(const Points& points) {
    double mx = 0.0;
    double my = 0.0;
    for (const auto& p : points) {
        mx += p[0];
        my += p[1];
    }
    const double n = static_cast<double>(points.size());
    mx /= n;
    my /= n;
    std::array<std::array<double, 3>, 3> a{};
    std::array<double, 3> b{};
    for (const auto& p : points) {
        const std::array row{p[0] - mx, p[1] - my, 1.0};
        const double square = row[0] * row[0] + row[1] * row[1];
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                a[i][j] += row[i] * row[j];
            }
            b[i] += row[i] * square;
        }
    }
    std::array<double, 3> x{};
    if (!solve3(a, b, x)) {
        return std::nullopt;
    }
    const double square = x[2] + 0.25 * (x[0] * x[0] + x[1] * x[1]);
    if (!(square > 0.0)) {
        return std::nullopt;
    }
    return Circle{.x = mx + 0.5 * x[0],
                  .y = my + 0.5 * x[1],
                  .radius = std::sqrt(square),
                  .residual = 0.0,
                  .used = points.size()};
}

bool newton(const Points& points, Circle& circle) {
    for (int round = 0; round < kNewtonRounds; ++round) {
        std::array<std::array<double, 3>, 3> a{};
        std::array<double, 3> b{};
        for (const auto& p : points) {
            const double dx = p[0] - circle.x;
            const double dy = p[1] - circle.y;
            const double r = std::max(std::hypot(dx, dy), 1e-9);
            const std::array row{dx / r, dy / r, 1.0};
            for (std::size_t i = 0; i < 3; ++i) {
                for (std::size_t j = 0; j < 3; ++j) {
                    a[i][j] += row[i] * row[j];
                }
                b[i] += row[i] * (r - circle.radius);
            }
        }
        std::array<double, 3> step{};
        if (!solve3(a, b, step)) {
            return false;
        }
        circle.x += step[0];
        circle.y += step[1];
        circle.radius += step[2];
        if (std::abs(step[0]) + std::abs(step[1]) + std::abs(step[2]) < 1e-9) {
            break;
        }
    }
    return circle.radius > 0.0 && std::isfinite(circle.x + circle.y + circle.radius);
}

std::vector<double> distances(const Points& points, const Circle& circle) {
    std::vector<double> out;
    out.reserve(points.size());
    for (const auto& p : points) {
        out.push_back(std::abs(std::hypot(p[0] - circle.x, p[1] - circle.y) - circle.radius));
    }
    return out;
}

}  // namespace

std::optional<Circle> fit_circle(std::span<const std::array<double, 2>> points) {
    Points kept(points.begin(), points.end());
    std::optional<Circle> circle;
    for (int round = 0; round < kRobustRounds; ++round) {
        if (kept.size() < kFewest) {
            return std::nullopt;
        }
        circle = algebraic(kept);
        if (!circle || !newton(kept, *circle)) {
            return std::nullopt;
        }
        // Distances of all points: one that was left out may come back.
        const std::vector<double> off = distances({points.begin(), points.end()}, *circle);
        std::vector<double> sorted = distances(kept, *circle);
        double squares = 0.0;
        for (const double d : sorted) {
            squares += d * d;
        }
        circle->used = kept.size();
        circle->residual = std::sqrt(squares / static_cast<double>(kept.size()));
        std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
        const double limit = std::max(kOutlier * kMadToSigma * sorted[sorted.size() / 2], 1e-6);
        Points next;
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (off[i] <= limit) {
                next.push_back(points[i]);
            }
        }
        if (next == kept) {
            break;
        }
        kept = std::move(next);
    }
    return circle;
}

}  // namespace sc::host
