// SPDX-License-Identifier: Apache-2.0
#include "shared/crypto/aes128.hpp"

#include <bit>
#include <cstddef>

namespace sc::crypto {
namespace {

constexpr std::uint8_t doubled(std::uint8_t x) noexcept {
    return static_cast<std::uint8_t>((unsigned{x} << 1U) ^ ((x & 0x80U) != 0 ? 0x1BU : 0U));
}

/// The S-box by its definition: inverse in GF(2^8) (walking 3^n and 3^-n together), then the affine map.
constexpr std::array<std::uint8_t, 256> substitution() noexcept {
    std::array<std::uint8_t, 256> box{};
    std::uint8_t p = 1;
    std::uint8_t q = 1;
    do {
        p = static_cast<std::uint8_t>(p ^ doubled(p));
        q = static_cast<std::uint8_t>(q ^ (q << 1U));
        q = static_cast<std::uint8_t>(q ^ (q << 2U));
        q = static_cast<std::uint8_t>(q ^ (q << 4U));
        q = static_cast<std::uint8_t>(q ^ ((q & 0x80U) != 0 ? 0x09U : 0U));
        const std::uint8_t mapped =
            static_cast<std::uint8_t>(q ^ std::rotl(q, 1) ^ std::rotl(q, 2) ^ std::rotl(q, 3) ^ std::rotl(q, 4));
        box[p] = static_cast<std::uint8_t>(mapped ^ 0x63U);
    } while (p != 1);
    box[0] = 0x63;
    return box;
}

/// SubBytes and MixColumns of a byte in row 0 of a column: 2s, s, s, 3s from the lowest byte up. A byte of row n gives
/// the same, rotated by 8n.
constexpr std::array<std::uint32_t, 256> mixed_table() noexcept {
    std::array<std::uint32_t, 256> table{};
    const auto box = substitution();
    for (std::size_t i = 0; i < table.size(); ++i) {
        const std::uint32_t s = box[i];
        const std::uint32_t twice = doubled(box[i]);
        table[i] = twice | (s << 8U) | (s << 16U) | ((twice ^ s) << 24U);
    }
    return table;
}
constexpr std::array<std::uint32_t, 256> kMixed = mixed_table();

constexpr std::uint32_t byte_of(std::uint32_t word, unsigned n) noexcept { return (word >> (8U * n)) & 0xFFU; }
std::uint32_t substituted(std::uint32_t byte) noexcept { return (kMixed[byte] >> 8U) & 0xFFU; }

std::uint32_t load(const std::uint8_t* from) noexcept {
    return from[0] | (std::uint32_t{from[1]} << 8U) | (std::uint32_t{from[2]} << 16U) | (std::uint32_t{from[3]} << 24U);
}

/// A column after ShiftRows, SubBytes and MixColumns; a to d are the columns that its rows come from.
std::uint32_t mixed(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) noexcept {
    return kMixed[byte_of(a, 0)] ^ std::rotl(kMixed[byte_of(b, 1)], 8) ^ std::rotl(kMixed[byte_of(c, 2)], 16) ^
           std::rotl(kMixed[byte_of(d, 3)], 24);
}
/// The same without MixColumns.
std::uint32_t last(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) noexcept {
    return substituted(byte_of(a, 0)) | (substituted(byte_of(b, 1)) << 8U) | (substituted(byte_of(c, 2)) << 16U) |
           (substituted(byte_of(d, 3)) << 24U);
}

}  // namespace

Aes128::Aes128(const Key& key) noexcept {
    for (std::size_t i = 0; i < 4; ++i) {
        round_keys_[i] = load(&key[4 * i]);
    }
    std::uint8_t round = 1;
    for (std::size_t i = 4; i < round_keys_.size(); ++i) {
        std::uint32_t word = round_keys_[i - 1];
        if (i % 4 == 0) {
            word = std::rotr(word, 8);
            word = last(word, word, word, word) ^ round;
            round = doubled(round);
        }
        round_keys_[i] = round_keys_[i - 4] ^ word;
    }
}

void Aes128::encrypt(Block& block) const noexcept {
    const std::uint32_t* key = round_keys_.data();
    std::uint32_t a = load(&block[0]) ^ key[0];
    std::uint32_t b = load(&block[4]) ^ key[1];
    std::uint32_t c = load(&block[8]) ^ key[2];
    std::uint32_t d = load(&block[12]) ^ key[3];
    for (int round = 1; round < 10; ++round) {
        key += 4;
        const std::uint32_t na = mixed(a, b, c, d) ^ key[0];
        const std::uint32_t nb = mixed(b, c, d, a) ^ key[1];
        const std::uint32_t nc = mixed(c, d, a, b) ^ key[2];
        d = mixed(d, a, b, c) ^ key[3];
        a = na;
        b = nb;
        c = nc;
    }
    key += 4;
    const std::array<std::uint32_t, 4> out{last(a, b, c, d) ^ key[0], last(b, c, d, a) ^ key[1],
                                           last(c, d, a, b) ^ key[2], last(d, a, b, c) ^ key[3]};
    for (std::size_t i = 0; i < block.size(); ++i) {
        block[i] = static_cast<std::uint8_t>(byte_of(out[i / 4], i % 4));
    }
}

}  // namespace sc::crypto
