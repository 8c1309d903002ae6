// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

/// Scalar mathematics of the control path: only + − × ÷ and the correctly rounded square root, so every core and
/// compiler gives the same bits. No libm.

namespace sc {

[[nodiscard]] constexpr double absolute(double v) noexcept { return v < 0.0 ? -v : v; }
[[nodiscard]] constexpr double smaller(double a, double b) noexcept { return b < a ? b : a; }
[[nodiscard]] constexpr double larger(double a, double b) noexcept { return a < b ? b : a; }
/// `v` limited to [low, high]; a NaN becomes `low`, so that what follows may convert it to an integer.
[[nodiscard]] constexpr double clamped(double v, double low, double high) noexcept {
    return v >= low ? (v <= high ? v : high) : low;
}
[[nodiscard]] inline double square_root(double v) noexcept { return __builtin_sqrt(v > 0.0 ? v : 0.0); }

/// Nearest integer, halves away from zero, limited to ±9e18.
[[nodiscard]] constexpr std::int64_t rounded(double v) noexcept {
    const double limited = clamped(v, -9e18, 9e18);
    const auto whole = static_cast<std::int64_t>(limited);
    const double rest = limited - static_cast<double>(whole);
    if (rest >= 0.5) {
        return whole + 1;
    }
    return rest <= -0.5 ? whole - 1 : whole;
}

namespace scalar_detail {
/// 1.5 · 2^52: a double this large has no binary places, so adding it leaves the nearest integer in the low bits.
inline constexpr double kNoBinaryPlaces = 6755399441055744.0;
}  // namespace scalar_detail

/// Nearest integer, halves to even, for |v| < 2^51; beyond that, and for a NaN, any integer (never undefined). For what
/// runs for each mirror frame and each pulse, where the caller knows the range. Needs the default rounding mode.
[[nodiscard]] constexpr std::int64_t nearest_within(double v) noexcept {
    const double shifted = v + scalar_detail::kNoBinaryPlaces;
    return std::bit_cast<std::int64_t>(shifted) - std::bit_cast<std::int64_t>(scalar_detail::kNoBinaryPlaces);
}
/// The same for |v| < 2^31.
[[nodiscard]] constexpr std::int32_t nearest32_within(double v) noexcept {
    const double shifted = v + scalar_detail::kNoBinaryPlaces;
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(shifted)));
}
/// The same number, for |v| < 2^51. Cores without a 64-bit conversion take 150 instructions for a static_cast, and this
/// takes six.
[[nodiscard]] constexpr double exact_double(std::int64_t v) noexcept {
    return std::bit_cast<double>(v + std::bit_cast<std::int64_t>(scalar_detail::kNoBinaryPlaces)) -
           scalar_detail::kNoBinaryPlaces;
}
/// The nearest double, halves to even, as a static_cast gives it; of any number. For the same cores: both halves are
/// exact, and their sum is rounded once.
[[nodiscard]] constexpr double nearest_double(std::int64_t v) noexcept {
    const auto high = static_cast<std::int32_t>(v >> 32U);
    const auto low = static_cast<std::uint32_t>(v & 0xFFFF'FFFF);
    return static_cast<double>(high) * 4294967296.0 + static_cast<double>(low);
}
/// Limited to ±2^51; a NaN becomes −2^51.
[[nodiscard]] constexpr std::int64_t nearest(double v) noexcept {
    constexpr double kLimit = 2251799813685248.0;
    return nearest_within(clamped(v, -kLimit, kLimit));
}
/// Limited to ±2'147'483'647.
[[nodiscard]] constexpr std::int32_t nearest32(double v) noexcept {
    return nearest32_within(clamped(v, -2147483647.0, 2147483647.0));
}

/// Cube root of v ≥ 0 (0 for less); relative error below 1e-15. Newton from a guess made of the exponent; the number of
/// steps is fixed, so the cost is too (about 60 operations).
[[nodiscard]] constexpr double cube_root(double v) noexcept {
    if (!(v > 0.0)) {
        return 0.0;
    }
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(v);
    double y = std::bit_cast<double>(bits / 3 + 0x2A9F7893782DA1CEULL);
    for (int i = 0; i < 6; ++i) {
        y = y - (y * y * y - v) / (3.0 * y * y);
    }
    return y;
}

}  // namespace sc
