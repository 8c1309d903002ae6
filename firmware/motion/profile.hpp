// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

/// Speed changes under limits of acceleration and jerk, with zero acceleration at both ends. Units: any length (m, or
/// degrees for C) and seconds. Pure functions; no libm.
///
/// A change of speed dv takes T = 2·sqrt(dv/j) where the acceleration limit is not reached (dv ≤ a²/j), else dv/a +
/// a/j. The profile is symmetric about its middle, so it covers (v0 + v1)/2 · T.

namespace sc::motion {

/// Acceleration and jerk along the path that may be used.
struct TangentLimits {
    double acceleration = 0.0;
    double jerk = 0.0;
};

[[nodiscard]] double change_time(double v0, double v1, const TangentLimits& limits) noexcept;
[[nodiscard]] double change_distance(double v0, double v1, const TangentLimits& limits) noexcept;

/// Highest speed that can be reached from v0 over `distance` (equally: the highest speed from which v0 can be reached).
/// Never more than what the distance allows; error below 1e-12 relative, to the low side.
[[nodiscard]] double reachable_speed(double v0, double distance, const TangentLimits& limits) noexcept;
/// A speed to which v0 can be brought over `distance`: 0 if it can be stopped, else the lowest that bisection finds.
/// (Going down to v0/3 takes more distance than stopping, so there may be a lower one.)
[[nodiscard]] double lowest_speed(double v0, double distance, const TangentLimits& limits) noexcept;

/// One stretch of constant jerk.
struct Phase {
    double duration = 0.0;
    double jerk = 0.0;
    double start_acceleration = 0.0;
};
struct PhaseList {
    std::array<Phase, 7> phase{};
    std::size_t count = 0;
    void add(double duration, double jerk, double start_acceleration) noexcept;
    /// The phases of one change of speed, with zero acceleration at both ends.
    void add_change(double v0, double v1, const TangentLimits& limits) noexcept;
};

/// Phases over `distance` from v0 to v1 at no more than `cap`, as fast as the limits allow. Needs v1 within reach of v0
/// and the other way round, both ≤ cap; a shortfall of rounding is made good by the cruise.
[[nodiscard]] PhaseList fastest_profile(double v0, double v1, double cap, double distance,
                                        const TangentLimits& limits) noexcept;

}  // namespace sc::motion
