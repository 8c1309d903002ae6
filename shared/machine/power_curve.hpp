// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace sc {

/// Average power of the source over its power byte, as a power meter behind the lens has shown it at the nominal pulse
/// rate; straight between its points. Without points: straight from nothing at 0 to LaserConfig::power at 255.
struct PowerCurve {
    static constexpr std::size_t kPoints = 17;
    std::array<std::uint8_t, kPoints> byte{};
    std::array<double, kPoints> watts{};
    std::uint8_t count = 0;

    [[nodiscard]] constexpr bool measured() const noexcept { return count > 0; }
    /// Least and greatest power that it knows; only of a measured one.
    [[nodiscard]] constexpr double least() const noexcept { return watts[0]; }
    [[nodiscard]] constexpr double most() const noexcept { return watts[count - 1U]; }
    constexpr bool operator==(const PowerCurve&) const noexcept = default;
};

/// No points, or 2 to 17 with bytes and watts both rising, the last byte 255, watts from 0 to 100 kW. Returns how many
/// points are sound from the first on: `count` if all are and their number is.
[[nodiscard]] constexpr std::size_t sound_points(const PowerCurve& curve) noexcept {
    constexpr double kMostWatts = 1e5;
    if (curve.count > PowerCurve::kPoints || curve.count == 1) {
        return 0;
    }
    for (std::size_t i = 0; i < curve.count; ++i) {
        const double w = curve.watts[i];
        const bool in_range = w >= 0.0 && w <= kMostWatts;
        const bool rises = i == 0 || (curve.byte[i] > curve.byte[i - 1] && w > curve.watts[i - 1]);
        const bool ends = i + 1U < curve.count || curve.byte[i] == 255;
        if (!in_range || !rises || !ends) {
            return i;
        }
    }
    return curve.count;
}
[[nodiscard]] constexpr bool sound(const PowerCurve& curve) noexcept {
    return curve.count <= PowerCurve::kPoints && curve.count != 1 && sound_points(curve) == curve.count;
}

}  // namespace sc
