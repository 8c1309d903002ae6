// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/trajectory/spec.hpp"
#include "shared/math/scalar.hpp"

/// Sums and lengths of scaled places, with a written-out order.

namespace sc::trajectory {

[[nodiscard]] constexpr Place plus(const Place& a, const Place& b) noexcept {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]};
}
[[nodiscard]] constexpr Place minus(const Place& a, const Place& b) noexcept {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]};
}
[[nodiscard]] constexpr Place times(double k, const Place& a) noexcept {
    return {k * a[0], k * a[1], k * a[2], k * a[3]};
}
/// a + k b
[[nodiscard]] constexpr Place along(const Place& a, double k, const Place& b) noexcept {
    return {a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2], a[3] + k * b[3]};
}
[[nodiscard]] constexpr double dot(const Place& a, const Place& b) noexcept {
    return (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3]);
}
/// Over x, y and z, which is where speed and distance are measured.
[[nodiscard]] constexpr double dot3(const Place& a, const Place& b) noexcept {
    return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}
[[nodiscard]] inline double length(const Place& a) noexcept { return square_root(dot(a, a)); }
[[nodiscard]] inline double length3(const Place& a) noexcept { return square_root(dot3(a, a)); }

}  // namespace sc::trajectory
