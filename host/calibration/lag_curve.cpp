// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/lag_curve.hpp"

#include <algorithm>
#include <cmath>

#include "shared/units/quantity.hpp"

namespace sc::host {
namespace {

/// Fine enough for a cubic between the steps to be exact to a picometre on any swing that mirrors can follow.
constexpr double kStep = 2e-6;

}  // namespace

LagCurve::LagCurve(const LagLine& line) : line_(line) {
    wave_ = line.amplitude != 0.0 && line.wavelength > 0.0 ? 2.0 * kPi / line.wavelength : 0.0;
    const auto steps = static_cast<int>(std::max(1.0, std::ceil(line.run / kStep)));
    step_ = line.run / steps;
    distance_.push_back(0.0);
    for (int i = 0; i < steps; ++i) {
        // Simpson's rule on a step.
        const auto stretch = [&](double u) { return std::hypot(1.0, slope_at(u)); };
        const double u = i * step_;
        const double sum = stretch(u) + 4.0 * stretch(u + 0.5 * step_) + stretch(u + step_);
        distance_.push_back(distance_.back() + step_ * sum / 6.0);
    }
}

double LagCurve::slope_at(double u) const { return line_.amplitude * wave_ * std::cos(wave_ * u); }

std::array<double, 2> LagCurve::place_of(double u) const {
    const std::size_t run = line_.along_x ? 0 : 1;
    std::array<double, 2> place = line_.start;
    place[run] += line_.way * u;
    place[1 - run] += line_.amplitude * std::sin(wave_ * u);
    return place;
}

double LagCurve::axis_of(double distance) const {
    const auto above = std::upper_bound(distance_.begin() + 1, distance_.end() - 1, distance);
    const auto i = static_cast<std::size_t>(above - distance_.begin());
    const double low = distance_[i - 1];
    double u = step_ * (static_cast<double>(i - 1) + (distance - low) / (distance_[i] - low));
    // Within a step the distance is straight to 1e-9 of it; once is enough to see the bend.
    const double base = step_ * static_cast<double>(i - 1);
    const double middle = std::hypot(1.0, slope_at(0.5 * (base + u)));
    const double ends = std::hypot(1.0, slope_at(base)) + std::hypot(1.0, slope_at(u));
    u -= (low + (u - base) * (ends + 4.0 * middle) / 6.0 - distance) / std::hypot(1.0, slope_at(u));
    return u;
}

LagCurve::Point LagCurve::at(double distance) const {
    const double inside = std::clamp(distance, 0.0, length());
    const double u = axis_of(inside);
    const double slope = slope_at(u);
    const double bend = -line_.amplitude * wave_ * wave_ * std::sin(wave_ * u);
    const double stretch = std::hypot(1.0, slope);
    const std::size_t run = line_.along_x ? 0 : 1;
    Point point;
    point.place = place_of(u);
    point.tangent[run] = line_.way / stretch;
    point.tangent[1 - run] = slope / stretch;
    if (inside == distance) {
        // d(tangent)/ds with the tangent (1, w') / sqrt(1 + w'^2).
        const double scale = bend / (stretch * stretch * stretch * stretch);
        point.curvature[run] = -line_.way * slope * scale;
        point.curvature[1 - run] = scale;
    }
    for (std::size_t i = 0; i < 2; ++i) {
        point.place[i] += (distance - inside) * point.tangent[i];
    }
    return point;
}

}  // namespace sc::host
