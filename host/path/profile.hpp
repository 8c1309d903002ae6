// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Times and distances of moves with limited acceleration and jerk, rest to rest. Any one length unit throughout.

namespace sc::host {

struct MoveLimits {
    double speed = 0.0;
    double acceleration = 0.0;
    double jerk = 0.0;
};

/// Time to change the speed by `speed` from no acceleration to none: v/a + a/J, or 2·√(v/J) if `a` is never reached.
[[nodiscard]] double speed_up_time(double speed, const MoveLimits& limits) noexcept;
/// Distance on the way: v/2 times that time.
[[nodiscard]] double speed_up_distance(double speed, const MoveLimits& limits) noexcept;
/// Time of a move over `distance` (its sign does not matter), the seven phases in closed form.
[[nodiscard]] double move_time(double distance, const MoveLimits& limits) noexcept;

}  // namespace sc::host
