// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "firmware/trajectory/piece.hpp"

/// Polynomials in the number of a mirror frame, k = 0, 1, 2 …, and their values one after the other. 100 kHz context.

namespace sc::laser {

/// Coefficients of 1, k, k² … k^degree.
template <std::size_t kDegree>
using FramePolynomial = std::array<double, kDegree + 1>;

/// `q` at begin + k · step; of degree 3 when q is. Some 60 operations, 25 for degree 3.
template <std::size_t kDegree>
[[nodiscard]] constexpr FramePolynomial<kDegree> over_frames(const trajectory::Quintic& q, double begin,
                                                             double step) noexcept {
    static_assert(kDegree == 3 || kDegree == 5);
    FramePolynomial<kDegree> c;
    for (std::size_t i = 0; i <= kDegree; ++i) {
        c[i] = q[i];
    }
    for (std::size_t low = 0; low < kDegree; ++low) {
        for (std::size_t i = kDegree; i-- > low;) {
            c[i] += begin * c[i + 1];
        }
    }
    double power = step;
    for (std::size_t i = 1; i <= kDegree; ++i) {
        c[i] *= power;
        power = power * step;
    }
    return c;
}

/// p + per_step · dp/dk + per_step2 · d²p/dk².
template <std::size_t kDegree>
[[nodiscard]] constexpr FramePolynomial<kDegree> led(const FramePolynomial<kDegree>& p, double per_step,
                                                     double per_step2) noexcept {
    FramePolynomial<kDegree> out = p;
    for (std::size_t i = 0; i < kDegree; ++i) {
        out[i] += per_step * (static_cast<double>(i + 1) * p[i + 1]);
    }
    for (std::size_t i = 0; i + 1 < kDegree; ++i) {
        out[i] += per_step2 * (static_cast<double>((i + 1) * (i + 2)) * p[i + 2]);
    }
    return out;
}
template <std::size_t kDegree>
[[nodiscard]] constexpr double value(const FramePolynomial<kDegree>& p, double k) noexcept {
    double sum = p[kDegree];
    for (std::size_t i = kDegree; i-- > 0;) {
        sum = p[i] + k * sum;
    }
    return sum;
}

/// Values at k = 0, 1, 2 … by forward differences: as many additions each as the degree. Over the hundred frames of a
/// tick rounding stays below 1e-12 of the largest value.
template <std::size_t kDegree>
class FrameValues {
public:
    constexpr explicit FrameValues(const FramePolynomial<kDegree>& k) noexcept : difference_(k) {
        static_assert(kDegree == 3 || kDegree == 5);
        if constexpr (kDegree == 3) {
            difference_[1] = k[1] + (k[2] + k[3]);
            difference_[2] = 2.0 * k[2] + 6.0 * k[3];
            difference_[3] = 6.0 * k[3];
        } else {
            difference_[1] = k[1] + (k[2] + (k[3] + (k[4] + k[5])));
            difference_[2] = 2.0 * k[2] + (6.0 * k[3] + (14.0 * k[4] + 30.0 * k[5]));
            difference_[3] = 6.0 * k[3] + (36.0 * k[4] + 150.0 * k[5]);
            difference_[4] = 24.0 * k[4] + 240.0 * k[5];
            difference_[5] = 120.0 * k[5];
        }
    }
    [[nodiscard]] constexpr double value() const noexcept { return difference_[0]; }
    constexpr void next() noexcept {
        for (std::size_t i = 0; i < kDegree; ++i) {
            difference_[i] += difference_[i + 1];
        }
    }

private:
    FramePolynomial<kDegree> difference_;
};

}  // namespace sc::laser
