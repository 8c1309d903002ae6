// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/trajectory/spec.hpp"
#include "shared/machine/machine.hpp"
#include "shared/math/scalar.hpp"

/// Places in h to axis set-points and back, through the calibrated geometry. Context: servo step; some 30 operations.

namespace sc::motion {

using trajectory::Place;

[[nodiscard]] constexpr Vec3 axes_from_h(const Compensation& compensation, const Vec3& place) noexcept {
    return compensation.axis_from_h * place + compensation.axis_offset;
}

/// Integer set-points for a place in h and an angle of C (degrees).
[[nodiscard]] constexpr AxisPositions set_point_of(const Compensation& compensation, const Place& place) noexcept {
    const Vec3 axes = axes_from_h(compensation, {place[0], place[1], place[2]});
    return {nearest(axes.x * kPmPerMetre), nearest(axes.y * kPmPerMetre), nearest(axes.z * kPmPerMetre),
            nearest(place[3] * kNdegPerDegree)};
}

/// The place whose set-points are `axes`. The map is within 1e-3 of identity, so each round of the fixed point gains
/// three digits.
[[nodiscard]] constexpr Place place_of(const Compensation& compensation, const AxisPositions& axes) noexcept {
    const Vec3 wanted{exact_double(axes[0]) / kPmPerMetre, exact_double(axes[1]) / kPmPerMetre,
                      exact_double(axes[2]) / kPmPerMetre};
    Vec3 place = wanted;
    for (int i = 0; i < 6; ++i) {
        place = place + (wanted - axes_from_h(compensation, place));
    }
    return {place.x, place.y, place.z, exact_double(axes[3]) / kNdegPerDegree};
}

}  // namespace sc::motion
