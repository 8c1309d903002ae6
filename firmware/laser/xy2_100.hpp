// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "shared/machine/machine.hpp"
#include "shared/math/scalar.hpp"

/// Galvo command to XY2-100 words, 16-bit format: control bits 001, sixteen data bits, even parity over the twenty.

namespace sc::laser {

/// The 20 bits of one channel, most significant first on the wire. `position` is signed about the field's centre.
[[nodiscard]] constexpr std::uint32_t xy2_100_word(std::int16_t position, GalvoConvention convention) noexcept {
    const auto two = static_cast<std::uint16_t>(position);
    const std::uint32_t wire = convention == GalvoConvention::offset_binary ? two ^ 0x8000U : two;
    const std::uint32_t word = 0x20000U | (wire << 1U);
    std::uint32_t parity = word;
    parity ^= parity >> 16U;
    parity ^= parity >> 8U;
    parity ^= parity >> 4U;
    parity ^= parity >> 2U;
    parity ^= parity >> 1U;
    return word | (parity & 1U);
}

/// Places in the field to counts, through the calibrated field correction.
class FieldMap {
public:
    FieldMap(const Compensation& compensation, double counts_per_metre) noexcept;
    /// (x, z) in metres about the field's centre. Clamped to 16 bits. 100 kHz context: no division, no root.
    [[nodiscard]] std::array<std::int16_t, 2> counts(double x, double z) const noexcept {
        return {nearest16(m_[0] * x + m_[1] * z + offset_[0]), nearest16(m_[2] * x + m_[3] * z + offset_[1])};
    }

private:
    static std::int16_t nearest16(double v) noexcept {
        return static_cast<std::int16_t>(nearest32(clamped(v, -32767.0, 32767.0)));
    }
    std::array<double, 4> m_{};
    std::array<double, 2> offset_{};
};

}  // namespace sc::laser
