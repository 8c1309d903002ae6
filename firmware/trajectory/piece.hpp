// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/trajectory/spec.hpp"
#include "shared/codes/codes.hpp"

namespace sc::trajectory {

/// k[0] + k[1] t + … + k[5] t⁵
using Quintic = std::array<double, 6>;

[[nodiscard]] constexpr double value(const Quintic& k, double t) noexcept {
    return k[0] + t * (k[1] + t * (k[2] + t * (k[3] + t * (k[4] + t * k[5]))));
}
[[nodiscard]] constexpr double rate(const Quintic& k, double t) noexcept {
    return k[1] + t * (2.0 * k[2] + t * (3.0 * k[3] + t * (4.0 * k[4] + t * (5.0 * k[5]))));
}
[[nodiscard]] constexpr double second_rate(const Quintic& k, double t) noexcept {
    return 2.0 * k[2] + t * (6.0 * k[3] + t * (12.0 * k[4] + t * (20.0 * k[5])));
}
[[nodiscard]] constexpr double third_rate(const Quintic& k, double t) noexcept {
    return 6.0 * k[3] + t * (24.0 * k[4] + t * (60.0 * k[5]));
}

/// A stretch of the nominal trajectory. Place, speed and acceleration are continuous from piece to piece; the jerk
/// steps. Time is nominal: hold, resume and override pass through it by a law of their own.
struct Piece {
    double start = 0.0;                      ///< s since the path's start
    double duration = 0.0;                   ///< s, more than 0
    std::array<Quintic, kAxisCount> axis{};  ///< m, and degrees for C, over the time since `start`
    Quintic distance{};                      ///< true length over x, y, z since the path's start, m
    std::uint32_t item = 0;                  ///< of the last point that is passed at or before `start`; never falls
    LimitedBy limited = LimitedBy::none;

    /// Place dt ≥ 0 after `start`.
    [[nodiscard]] constexpr Place place(double dt) const noexcept {
        return {value(axis[0], dt), value(axis[1], dt), value(axis[2], dt), value(axis[3], dt)};
    }
};

/// Place or distance, speed and acceleration at one moment.
struct Motion {
    double p = 0.0;
    double v = 0.0;
    double a = 0.0;
};

/// The quintic with the given ends.
[[nodiscard]] Quintic hermite(const Motion& from, const Motion& to, double duration) noexcept;

/// Greatest |second rate| and |third rate| within the duration; exact, by the roots of the derivative.
struct Peaks {
    double acceleration = 0.0;
    double jerk = 0.0;
};
[[nodiscard]] Peaks peaks(const Quintic& k, double duration) noexcept;

}  // namespace sc::trajectory
