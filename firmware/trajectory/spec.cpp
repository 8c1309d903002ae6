// SPDX-License-Identifier: Apache-2.0
#include "firmware/trajectory/spec.hpp"

#include "shared/math/scalar.hpp"

namespace sc::trajectory {
namespace {

constexpr double kLowest = 1e-6;
constexpr double kHighest = 1e9;
constexpr double kCornerCosine = 0.70710678118654757;  ///< 45°
constexpr double kSharpCosine = 1.0 - 5e-13;           ///< 1 µrad
constexpr double kLeastRounding = 1e-7;                ///< m
constexpr double kLeastCurve = 1e-9;                   ///< m, of what is not a corner
constexpr double kCellsPerBraking = 9.0;
constexpr double kStepsPerBraking = 22.0;
constexpr double kLongestCell = 2e-3;  ///< s, at full speed, if braking is shorter
constexpr double kBrakingsAhead = 3.0;
constexpr double kNearRest = 0.4;  ///< of that

bool in_range(double v) noexcept { return v >= kLowest && v <= kHighest; }

/// Length of a stop from `speed` with jerk.
double braking(double speed, double acceleration, double jerk) noexcept {
    const double time = speed * jerk > acceleration * acceleration ? speed / acceleration + acceleration / jerk
                                                                   : 2.0 * square_root(speed / jerk);
    return 0.5 * speed * time;
}

}  // namespace

std::expected<Limits, Refusal> make_limits(const Spec& spec) noexcept {
    if (!(spec.speed >= kLowest && spec.speed <= 1e3)) {
        return std::unexpected(Refusal{.problem = Problem::bad_speed});
    }
    if (!(spec.tolerance >= 0.0 && spec.tolerance <= 1.0)) {
        return std::unexpected(Refusal{.problem = Problem::bad_tolerance});
    }
    Limits limits;
    limits.speed = spec.speed;
    limits.tolerance = larger(spec.tolerance, kLeastCurve);
    bool any = false;
    double slowest = 0.0;
    double fastest = kHighest;
    double stub = 0.0;
    for (std::size_t k = 0; k < kAxisCount; ++k) {
        const double v = spec.limits.speed[k];
        const double a = spec.limits.acceleration[k];
        const double j = spec.limits.jerk[k];
        if (v == 0.0 && a == 0.0 && j == 0.0) {
            continue;
        }
        if (!in_range(v) || !in_range(a) || !in_range(j)) {
            return std::unexpected(Refusal{.problem = Problem::bad_limit, .axis = static_cast<std::uint8_t>(k)});
        }
        const double scale = k == 3 ? spec.speed / v : 1.0;
        if (k == 3) {
            limits.metres_per_turn_unit = scale;
        }
        limits.velocity[k] = v * scale;
        limits.acceleration[k] = a * scale;
        limits.jerk[k] = j * scale;
        any = true;
        const double stop = braking(spec.speed, a * scale, j * scale);
        slowest = larger(slowest, stop);
        fastest = smaller(fastest, stop);
        stub = larger(stub, a * scale * a * a / (6.0 * j * j));
    }
    if (!any) {
        return std::unexpected(Refusal{.problem = Problem::bad_limit});
    }
    limits.merge = clamped(0.2 * spec.tolerance, 1e-9, 2e-6);
    limits.corner_cosine = spec.tolerance < kLeastRounding ? kSharpCosine : kCornerCosine;
    limits.longest_cell = larger(fastest / kCellsPerBraking, kLongestCell * spec.speed);
    limits.longest_step = larger(fastest / kStepsPerBraking, 0.2 * kLongestCell * spec.speed);
    limits.stub = larger(smaller(30.0 * spec.tolerance, 2.5 * stub), 10.0 * limits.merge);
    limits.window = larger(kBrakingsAhead * slowest, 8.0 * limits.longest_cell);
    limits.near_rest = larger(kNearRest * kBrakingsAhead * slowest, limits.longest_cell);
    return limits;
}

}  // namespace sc::trajectory
