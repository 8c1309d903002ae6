// SPDX-License-Identifier: Apache-2.0
#include "host/verification/line_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace sc::host {

namespace {

constexpr double kDeviationOfMedian = 1.4826;  ///< standard deviation / median of |error|, normal errors
constexpr double kOutlier = 4.0;
constexpr double kLeastOutlier = 1e-6;
constexpr int kRounds = 6;

bool fit_counted(std::span<const Flat> places, FlatLine& line) {
    double count = 0.0;
    Flat sum;
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (line.counts[i]) {
            sum = sum + (places[i] - places.front());
            count += 1.0;
        }
    }
    if (count < 2.0) {
        return false;
    }
    line.point = places.front() + (1.0 / count) * sum;
    double xx = 0.0;
    double xz = 0.0;
    double zz = 0.0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (line.counts[i]) {
            const Flat d = places[i] - line.point;
            xx += d.x * d.x;
            xz += d.x * d.z;
            zz += d.z * d.z;
        }
    }
    if (!(xx + zz > 0.0)) {
        return false;
    }
    const double angle = 0.5 * std::atan2(2.0 * xz, xx - zz);
    line.direction = {std::cos(angle), std::sin(angle)};
    return true;
}

/// Marks the outliers anew; true if anything changed.
bool mark_outliers(std::span<const Flat> places, FlatLine& line) {
    std::vector<double> distance;
    distance.reserve(places.size());
    for (const Flat& p : places) {
        distance.push_back(std::abs(line.off(p)));
    }
    std::vector<double> sorted = distance;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const double most = std::max(kOutlier * kDeviationOfMedian * *middle, kLeastOutlier);
    bool changed = false;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const bool counts = distance[i] <= most;
        changed = changed || counts != line.counts[i];
        line.counts[i] = counts;
    }
    return changed;
}

void measure(std::span<const Flat> places, FlatLine& line) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    line.first = kFar;
    line.last = -kFar;
    double least = kFar;
    double most = -kFar;
    double squares = 0.0;
    double count = 0.0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (line.counts[i]) {
            const double s = line.along(places[i]);
            const double off = line.off(places[i]);
            line.first = std::min(line.first, s);
            line.last = std::max(line.last, s);
            least = std::min(least, off);
            most = std::max(most, off);
            squares += off * off;
            count += 1.0;
        }
    }
    line.rms = std::sqrt(squares / count);
    line.swing = most - least;
}

}  // namespace

double length(const Flat& a) noexcept { return std::hypot(a.x, a.z); }

std::optional<FlatLine> fit_line(std::span<const Flat> places) {
    FlatLine line;
    line.counts.assign(places.size(), true);
    if (!fit_counted(places, line)) {
        return std::nullopt;
    }
    for (int round = 0; round < kRounds && mark_outliers(places, line); ++round) {
        if (!fit_counted(places, line)) {
            return std::nullopt;
        }
    }
    measure(places, line);
    return line;
}

Trend fit_trend(std::span<const double> s, std::span<const double> value, const std::vector<bool>& counts) {
    double count = 0.0;
    double s_sum = 0.0;
    double v_sum = 0.0;
    for (std::size_t i = 0; i < s.size(); ++i) {
        if (counts[i]) {
            count += 1.0;
            s_sum += s[i];
            v_sum += value[i];
        }
    }
    if (count == 0.0) {
        return {};
    }
    const double s_mean = s_sum / count;
    const double v_mean = v_sum / count;
    double ss = 0.0;
    double sv = 0.0;
    for (std::size_t i = 0; i < s.size(); ++i) {
        if (counts[i]) {
            ss += (s[i] - s_mean) * (s[i] - s_mean);
            sv += (s[i] - s_mean) * (value[i] - v_mean);
        }
    }
    const double slope = ss > 0.0 ? sv / ss : 0.0;
    return {v_mean - slope * s_mean, slope};
}

std::optional<Flat> meeting_point(const FlatLine& a, const FlatLine& b) noexcept {
    const double sine = cross(a.direction, b.direction);
    if (std::abs(sine) < 1e-6) {
        return std::nullopt;
    }
    const double s = cross(b.point - a.point, b.direction) / sine;
    return a.at(s);
}

}  // namespace sc::host
