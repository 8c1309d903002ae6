// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/xy2_100.hpp"

#include "shared/math/scalar.hpp"

namespace sc::laser {

std::array<std::int16_t, 2> galvo_counts(double x, double z, const Compensation& compensation,
                                         double counts_per_metre) noexcept {
    const std::array<double, 4>& m = compensation.galvo_from_field;
    const double gx = (m[0] * x + m[1] * z) + compensation.galvo_offset[0];
    const double gz = (m[2] * x + m[3] * z) + compensation.galvo_offset[1];
    const auto counts = [&](double v) noexcept {
        return static_cast<std::int16_t>(rounded(clamped(v * counts_per_metre, -32767.0, 32767.0)));
    };
    return {counts(gx), counts(gz)};
}

}  // namespace sc::laser
