// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "shared/math/scalar.hpp"

/// Angles in radians without libm: the same bits on every core and with every compiler.

namespace sc {

inline constexpr double kHalfTurn = 3.14159265358979323846;

struct SineCosine {
    double sine = 0.0;
    double cosine = 1.0;
};

/// Of |angle| ≤ 0.5, within 2e-16. Cost: 40 operations.
[[nodiscard]] constexpr SineCosine sine_cosine_of_small(double angle) noexcept {
    const double x = angle * angle;
    double sine = 1.0;
    double cosine = 1.0;
    for (int n = 16; n > 0; n -= 2) {
        sine = 1.0 - sine * x / (n * (n + 1));
        cosine = 1.0 - cosine * x / (n * (n - 1));
    }
    return {angle * sine, cosine};
}

/// The angle in [0, 2π) of the direction (x, y), which need not be of length 1; 0 if both are 0. Within 1e-15 of its
/// value. Cost: 80 operations.
[[nodiscard]] inline double angle_of(double x, double y) noexcept {
    const double length = square_root(x * x + y * y);
    if (!(length > 0.0)) {
        return 0.0;
    }
    // Of the direction mirrored into the first octant; halved twice; then a series that ends below 0.2^23.
    const double a = absolute(x);
    const double b = absolute(y);
    double cosine = larger(a, b) / length;
    double sine = smaller(a, b) / length;
    for (int i = 0; i < 2; ++i) {
        const double half = square_root(0.5 * (1.0 + cosine));
        sine = 0.5 * sine / half;
        cosine = half;
    }
    const double t = sine / cosine;
    double sum = 0.0;
    for (int n = 21; n > 0; n -= 2) {
        sum = 1.0 / n - sum * t * t;
    }
    double angle = 4.0 * t * sum;
    angle = b > a ? 0.5 * kHalfTurn - angle : angle;
    angle = x < 0.0 ? kHalfTurn - angle : angle;
    return y < 0.0 ? 2.0 * kHalfTurn - angle : angle;
}

}  // namespace sc
