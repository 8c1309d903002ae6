// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "shared/machine/machine.hpp"
#include "shared/math/scalar.hpp"

/// Galvo command to XY2-100 words, 16-bit format: control bits 001, sixteen data bits, even parity over the twenty.

namespace sc::laser {

/// What a head's convention turns over in a two's complement position.
[[nodiscard]] constexpr std::uint32_t xy2_100_flip(GalvoConvention convention) noexcept {
    return convention == GalvoConvention::offset_binary ? 0x8000U : 0U;
}

/// The 20 bits of one channel, most significant first on the wire; `wire` is the position as the head reads it, 16
/// bits.
[[nodiscard]] constexpr std::uint32_t xy2_100_frame(std::uint32_t wire) noexcept {
    constexpr std::uint32_t kEvenOf16 = 0x9669U;  // bit n: the parity of n, and of the one control bit that is set
    std::uint32_t fold = wire ^ (wire >> 8U);
    fold ^= fold >> 4U;
    return 0x20000U | (wire << 1U) | ((kEvenOf16 >> (fold & 0xFU)) & 1U);
}
/// `position` is signed about the field's centre.
[[nodiscard]] constexpr std::uint32_t xy2_100_word(std::int16_t position, GalvoConvention convention) noexcept {
    return xy2_100_frame(static_cast<std::uint16_t>(position) ^ xy2_100_flip(convention));
}

/// Places in the field to counts and words, through the calibrated field correction. (x, z) in metres about the field's
/// centre, |x|, |z| < 1 m. Clamped to 16 bits. 100 kHz context: no division, no root.
class FieldMap {
public:
    FieldMap(const Compensation& compensation, const GalvoConfig& galvo) noexcept;
    [[nodiscard]] std::array<std::int32_t, 2> counts(double x, double z) const noexcept {
        return {within_16(nearest32_within(m_[0] * x + m_[1] * z + offset_[0])),
                within_16(nearest32_within(m_[2] * x + m_[3] * z + offset_[1]))};
    }
    [[nodiscard]] std::array<std::uint32_t, 2> words(double x, double z) const noexcept {
        const std::array<std::int32_t, 2> c = counts(x, z);
        return {xy2_100_frame((static_cast<std::uint32_t>(c[0]) ^ flip_) & 0xFFFFU),
                xy2_100_frame((static_cast<std::uint32_t>(c[1]) ^ flip_) & 0xFFFFU)};
    }

private:
    static std::int32_t within_16(std::int32_t v) noexcept {
        constexpr std::int32_t kMost = 32767;
        return v > kMost ? kMost : (v < -kMost ? -kMost : v);
    }
    std::array<double, 4> m_{};
    std::array<double, 2> offset_{};
    std::uint32_t flip_ = 0;
};

}  // namespace sc::laser
