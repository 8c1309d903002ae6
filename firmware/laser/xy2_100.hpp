// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "shared/machine/machine.hpp"

/// Galvo command to XY2-100 words. 16-bit format: control bits 001, sixteen data bits, even parity over the twenty.
/// 18-bit format: control bit 1, eighteen data bits, odd parity.

namespace sc::laser {

/// One format of words with one convention of signs. 100 kHz context: no branch, no division.
class WordFormat {
public:
    constexpr WordFormat(GalvoWord word, GalvoConvention convention) noexcept {
        const bool wide = word == GalvoWord::bits18;
        head_ = wide ? 0x80000U : 0x20000U;
        mask_ = wide ? 0x3FFFFU : 0xFFFFU;
        // Bit n: the parity bit for data that fold to n.
        parity_ = wide ? 0x6996U : 0x9669U;
        flip_ = convention == GalvoConvention::offset_binary ? (mask_ + 1U) / 2U : 0U;
        most_ = static_cast<std::int32_t>(mask_ / 2U);
        scale_ = wide ? 4.0 : 1.0;
    }
    /// Words of this format for one 16-bit count.
    [[nodiscard]] constexpr double scale() const noexcept { return scale_; }
    /// Largest position; −most is the smallest that is sent.
    [[nodiscard]] constexpr std::int32_t most() const noexcept { return most_; }
    [[nodiscard]] constexpr std::int32_t within(std::int32_t position) const noexcept {
        return position > most_ ? most_ : (position < -most_ ? -most_ : position);
    }
    /// The 20 bits of one channel, most significant first on the wire. `position` is signed about the field's centre;
    /// what does not fit is cut off, so clamp it before.
    [[nodiscard]] constexpr std::uint32_t word(std::int32_t position) const noexcept {
        const std::uint32_t wire = (static_cast<std::uint32_t>(position) ^ flip_) & mask_;
        std::uint32_t fold = wire ^ (wire >> 16U);
        fold ^= fold >> 8U;
        fold ^= fold >> 4U;
        return head_ | (wire << 1U) | ((parity_ >> (fold & 0xFU)) & 1U);
    }
    [[nodiscard]] constexpr bool wide() const noexcept { return mask_ > 0xFFFFU; }
    /// `within` and `word` of both mirrors at once, for loops that know the width: a third of the instructions.
    template <GalvoWord kWord>
    [[nodiscard]] constexpr std::array<std::uint32_t, 2> clamped_words(std::int32_t x, std::int32_t z) const noexcept {
        constexpr bool kWide = kWord == GalvoWord::bits18;
        constexpr std::int32_t kMost = kWide ? 131071 : 32767;
        constexpr std::int32_t kHalf = kMost + 1;
        // Offset binary behind the control bits; the other convention has its sign bit the other way.
        const std::uint32_t other = flip_ ^ static_cast<std::uint32_t>(kHalf);
        const auto code = [other](std::int32_t position) noexcept {
            const std::int32_t in = position > kMost ? kMost : (position < -kMost ? -kMost : position);
            return static_cast<std::uint32_t>(in + 3 * kHalf) ^ other;
        };
        const std::uint32_t code_x = code(x);
        const std::uint32_t code_z = code(z);
        // Parity of both in one word: each half folds onto its lowest bit. Of 18 bits the upper ones are folded first.
        const std::uint32_t low_x = kWide ? code_x ^ (code_x >> 16U) : code_x;
        const std::uint32_t low_z = kWide ? code_z ^ (code_z >> 16U) : code_z;
        std::uint32_t fold = (low_x & 0xFFFFU) | (low_z << 16U);
        fold ^= fold >> 8U;
        fold ^= fold >> 4U;
        fold ^= fold >> 2U;
        fold ^= fold >> 1U;
        // 18 bits: the control bit was folded in, and the parity is odd; 16 bits: it was not, and the parity is even.
        fold = ~fold;
        return {(code_x << 1U) | (fold & 1U), (code_z << 1U) | ((fold >> 16U) & 1U)};
    }
    /// The position that a word of this format asks for; parity and control bits are not looked at.
    [[nodiscard]] constexpr std::int32_t position(std::uint32_t word) const noexcept {
        const std::uint32_t data = ((word >> 1U) ^ flip_) & mask_;
        const auto sign = static_cast<std::int32_t>((mask_ + 1U) / 2U);
        return static_cast<std::int32_t>(data ^ static_cast<std::uint32_t>(sign)) - sign;
    }

private:
    std::uint32_t head_ = 0;
    std::uint32_t mask_ = 0;
    std::uint32_t parity_ = 0;
    std::uint32_t flip_ = 0;
    std::int32_t most_ = 0;
    double scale_ = 1.0;
};

/// One word, for where speed does not matter.
[[nodiscard]] constexpr std::uint32_t xy2_100_word(std::int32_t position, GalvoConvention convention,
                                                   GalvoWord word = GalvoWord::bits16) noexcept {
    return WordFormat(word, convention).word(position);
}

}  // namespace sc::laser
