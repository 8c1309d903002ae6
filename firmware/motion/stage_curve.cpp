// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/stage_curve.hpp"

#include "shared/math/scalar.hpp"

namespace sc::motion {
namespace {

constexpr double kShare = 0.5;  ///< of the limits for the curve itself
constexpr std::int64_t kMostPm = 2'000'000'000'000'000;
/// Control points are rounded to the wire's unit: what that can make of their first three differences.
constexpr std::array<double, 3> kRounding{1.0 / kWireUnitsPerMetre, 2.0 / kWireUnitsPerMetre, 4.0 / kWireUnitsPerMetre};

}  // namespace

bool StageCurve::begin(double spacing) noexcept {
    if (!(spacing >= kLeastKnotSpacing && spacing <= kMostKnotSpacing)) {
        return false;
    }
    spacing_ = spacing;
    per_spacing_ = 1.0 / spacing;
    return true;
}

void StageCurve::push(const StageKnot& knot) noexcept {
    knots_[end_ % kCapacity] = {static_cast<double>(knot.x) / kWireUnitsPerMetre,
                                static_cast<double>(knot.y) / kWireUnitsPerMetre,
                                static_cast<double>(knot.z) / kWireUnitsPerMetre};
    ++end_;
}

StageCurve::Breach StageCurve::check(double speed, double tick, const trajectory::AxisLimits& limits) const noexcept {
    if (end_ < 4) {
        return {};
    }
    const double per_t = 1.0 / (static_cast<double>(kStageSmoothing) * tick);
    const double scale = speed * per_spacing_;
    const std::array<Point, 4> c{knot(3), knot(2), knot(1), knot(0)};
    for (std::size_t i = 0; i < 3; ++i) {
        const std::array<double, 3> d{c[1][i] - c[0][i], c[2][i] - c[1][i], c[3][i] - c[2][i]};
        const double first = larger(larger(absolute(d[0]), absolute(d[1])), absolute(d[2])) - kRounding[0];
        const double second = larger(absolute(d[1] - d[0]), absolute(d[2] - d[1])) - kRounding[1];
        const double third = absolute((d[2] - d[1]) - (d[1] - d[0])) - kRounding[2];
        const double v = larger(first, 0.0) * scale;
        const double a = larger(second, 0.0) * (scale * scale);
        const double j = larger(third, 0.0) * (scale * scale * scale);
        const double whole_a = a + v * per_t;
        const double whole_j = j + (3.0 * a + 2.0 * v * per_t) * per_t;
        if (!(v <= kShare * limits.speed[i])) {
            return {true, i, v};
        }
        if (!(a <= kShare * limits.acceleration[i] && whole_a <= limits.acceleration[i])) {
            return {true, i, whole_a};
        }
        if (!(j <= kShare * limits.jerk[i] && whole_j <= limits.jerk[i])) {
            return {true, i, whole_j};
        }
    }
    return {};
}

/// Number of the knot before a distance, held to those whose four control points are known.
std::uint32_t StageCurve::interval(double distance) const noexcept {
    const auto knots = static_cast<std::uint32_t>(clamped(distance * per_spacing_, 0.0, 4e9));
    const std::uint32_t last = end_ - 4;
    return knots < first_ ? first_ : knots < last ? knots : last;
}

bool StageCurve::reaches(double distance) const noexcept {
    return end_ >= 4 && distance * per_spacing_ < static_cast<double>(end_ - 3);
}

StageCurve::Point StageCurve::at(double distance) const noexcept {
    const std::uint32_t i = interval(distance);
    const double x = clamped(distance * per_spacing_ - static_cast<double>(i), 0.0, 1.0);
    const double y = 1.0 - x;
    const double sixth = 1.0 / 6.0;
    const double w0 = y * y * y * sixth;
    const double w3 = x * x * x * sixth;
    const double w2 = 2.0 / 3.0 - y * y * (1.0 - 0.5 * y);
    const std::array<const Point*, 4> c{&number(i), &number(i + 1), &number(i + 2), &number(i + 3)};
    Point place{};
    for (std::size_t k = 0; k < 3; ++k) {
        const double middle = (*c[1])[k];
        // About the second one: a curve that stands is exactly there.
        place[k] = middle + (w0 * ((*c[0])[k] - middle) + (w2 * ((*c[2])[k] - middle) + w3 * ((*c[3])[k] - middle)));
    }
    return place;
}

void StageCurve::forget_before(double distance) noexcept {
    if (end_ >= 4) {
        first_ = interval(distance);
    }
}

double StageFollower::push(std::int64_t distance_pm) noexcept {
    still_ = distance_pm > most_ ? 0 : still_ + (settled() ? 0U : 1U);
    most_ = distance_pm > most_ ? distance_pm : most_;
    most_ = most_ < kMostPm ? most_ : kMostPm;
    first_sum_ += most_ - distance_[at_];
    distance_[at_] = most_;
    second_sum_ += first_sum_ - mean_[at_];
    mean_[at_] = first_sum_;
    at_ = (at_ + 1) % kStageSmoothing;
    constexpr std::uint64_t kWeight = std::uint64_t{kStageSmoothing} * kStageSmoothing;
    // Never negative. Below 2^51 it converts at once: whole picometres, and what is left of one.
    const auto sum = static_cast<std::uint64_t>(second_sum_);
    const auto whole = static_cast<std::int64_t>(sum / kWeight);
    const auto rest = static_cast<std::uint32_t>(sum % kWeight);
    return (exact_double(whole) + static_cast<double>(rest) * (1.0 / static_cast<double>(kWeight))) * 1e-12;
}

void StageHistory::push(const StageCurve::Point& place) noexcept {
    at_ = (at_ + 1) % kTicks;
    places_[at_] = place;
    StageCurve::Point& control = controls_[(at_ + kTicks - 1) % kTicks];
    for (std::size_t i = 0; i < place.size(); ++i) {
        const double p = past(i, 1);
        control[i] = p - ((past(i, 2) - p) + (past(i, 0) - p)) * (1.0 / 6.0);
    }
}

double StageHistory::next_begins(double late) noexcept {
    const auto whole = static_cast<std::uint32_t>(late);
    const double part = late - static_cast<double>(whole);
    return part > 0.0 ? part : 1.0;
}

StageHistory::Cubic StageHistory::law(std::size_t axis, double late, bool next) const noexcept {
    // Between the set-points of `back` ticks ago and the one after, x0 behind the former.
    const auto whole = static_cast<std::uint32_t>(late);
    const std::uint32_t back = (static_cast<double>(whole) < late ? whole + 1 : whole) - (next ? 1U : 0U);
    const double x0 = static_cast<double>(back) - late;
    const double c1 = control(axis, back);
    const double d0 = control(axis, back + 1) - c1;
    const double d2 = control(axis, back - 1) - c1;
    const double d3 = control(axis, back - 2) - c1;
    const Cubic k{c1 + (d0 + d2) * (1.0 / 6.0), (d2 - d0) * 0.5, (d0 + d2) * 0.5, (d3 - d0 - 3.0 * d2) * (1.0 / 6.0)};
    return {k[0] + x0 * (k[1] + x0 * (k[2] + x0 * k[3])), k[1] + x0 * (2.0 * k[2] + 3.0 * x0 * k[3]),
            k[2] + 3.0 * x0 * k[3], k[3]};
}

bool StageHistory::stands() const noexcept {
    for (std::uint32_t ago = 1; ago < kTicks; ++ago) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (past(axis, ago) != past(axis, 0)) {
                return false;
            }
        }
    }
    return true;
}

}  // namespace sc::motion
