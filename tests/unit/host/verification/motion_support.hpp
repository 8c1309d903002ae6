// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

#include "host/verification/motion_checker.hpp"

/// Motions made for the checker's tests: straight moves of up to seven phases of constant jerk, sampled at 1 kHz.

namespace sc::host::test {

inline constexpr double kTick = 1e-3;

/// A move from rest to rest in seven phases that reaches its jerk, acceleration and speed.
struct SevenPhases {
    double way = 0.0;
    double speed = 0.0;
    double acceleration = 0.0;
    double jerk = 0.0;

    [[nodiscard]] double ramp() const { return acceleration / jerk; }
    [[nodiscard]] double hold() const { return speed / acceleration - ramp(); }
    [[nodiscard]] double rise() const { return 2.0 * ramp() + hold(); }
    [[nodiscard]] double cruise() const { return way / speed - rise(); }
    [[nodiscard]] double seconds() const { return 2.0 * rise() + cruise(); }
    [[nodiscard]] double at(double t) const { return speed_up(t) - speed_up(t - rise() - cruise()); }

private:
    [[nodiscard]] double speed_up(double t) const {
        const auto cube = [this](double since) { return since > 0.0 ? jerk * since * since * since / 6.0 : 0.0; };
        return cube(t) - cube(t - ramp()) - cube(t - ramp() - hold()) + cube(t - 2.0 * ramp() - hold());
    }
};

/// Parts of the limits of an axis that a move reaches.
inline SevenPhases move_of(const AxisLimits& limits, double speed, double acceleration, double jerk) {
    SevenPhases move{0.0, speed * limits.speed, acceleration * limits.acceleration, jerk * limits.jerk};
    move.way = move.speed * (2.0 * move.ramp() + move.hold() + 0.05);
    return move;
}

/// Samples of places in base units, from `before` ticks before 0 to `after` ticks after the end.
inline std::vector<AxisPositions> sampled(double seconds, const std::function<std::array<double, 4>(double)>& place,
                                          double phase = 0.0, int rest = 3) {
    std::vector<AxisPositions> samples;
    const auto last = static_cast<int>(std::ceil(seconds / kTick)) + rest;
    for (int n = -rest; n <= last; ++n) {
        const double t = std::clamp((n + phase) * kTick, 0.0, seconds);
        const std::array<double, 4> at = place(t);
        AxisPositions& sample = samples.emplace_back();
        for (std::size_t i = 0; i < 4; ++i) {
            sample[i] = std::llround(at[i] * units_per_base(i));
        }
    }
    return samples;
}

inline std::vector<AxisPositions> sampled_axis(std::size_t axis, const SevenPhases& move, double phase = 0.0) {
    return sampled(
        move.seconds(),
        [&](double t) {
            std::array<double, 4> at{};
            at[axis] = move.at(t);
            return at;
        },
        phase);
}

/// All places where something is broken are of this rule and axis, and there is one.
inline bool only(const MotionReport& report, Breach breach, std::string_view axis) {
    return !report.passed() &&
           std::ranges::all_of(report.first, [&](const Violation& v) { return v.breach == breach && v.axis == axis; });
}

}  // namespace sc::host::test
