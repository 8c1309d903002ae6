// SPDX-License-Identifier: Apache-2.0
#include "shared/hash/sha256.hpp"

#include <bit>

namespace sc {
namespace {

// First 32 bits of the fractions of the cube roots of the first 64 primes.
constexpr std::array<std::uint32_t, 64> kRound{
    0x428A2F98U, 0x71374491U, 0xB5C0FBCFU, 0xE9B5DBA5U, 0x3956C25BU, 0x59F111F1U, 0x923F82A4U, 0xAB1C5ED5U,
    0xD807AA98U, 0x12835B01U, 0x243185BEU, 0x550C7DC3U, 0x72BE5D74U, 0x80DEB1FEU, 0x9BDC06A7U, 0xC19BF174U,
    0xE49B69C1U, 0xEFBE4786U, 0x0FC19DC6U, 0x240CA1CCU, 0x2DE92C6FU, 0x4A7484AAU, 0x5CB0A9DCU, 0x76F988DAU,
    0x983E5152U, 0xA831C66DU, 0xB00327C8U, 0xBF597FC7U, 0xC6E00BF3U, 0xD5A79147U, 0x06CA6351U, 0x14292967U,
    0x27B70A85U, 0x2E1B2138U, 0x4D2C6DFCU, 0x53380D13U, 0x650A7354U, 0x766A0ABBU, 0x81C2C92EU, 0x92722C85U,
    0xA2BFE8A1U, 0xA81A664BU, 0xC24B8B70U, 0xC76C51A3U, 0xD192E819U, 0xD6990624U, 0xF40E3585U, 0x106AA070U,
    0x19A4C116U, 0x1E376C08U, 0x2748774CU, 0x34B0BCB5U, 0x391C0CB3U, 0x4ED8AA4AU, 0x5B9CCA4FU, 0x682E6FF3U,
    0x748F82EEU, 0x78A5636FU, 0x84C87814U, 0x8CC70208U, 0x90BEFFFAU, 0xA4506CEBU, 0xBEF9A3F7U, 0xC67178F2U};

constexpr std::uint32_t big_endian(std::span<const std::uint8_t, 64> chunk, std::size_t word) noexcept {
    const std::size_t i = 4 * word;
    return (std::uint32_t{chunk[i]} << 24U) | (std::uint32_t{chunk[i + 1]} << 16U) |
           (std::uint32_t{chunk[i + 2]} << 8U) | std::uint32_t{chunk[i + 3]};
}

std::array<std::uint32_t, 64> schedule(std::span<const std::uint8_t, 64> chunk) noexcept {
    std::array<std::uint32_t, 64> w{};
    for (std::size_t i = 0; i < 16; ++i) {
        w[i] = big_endian(chunk, i);
    }
    for (std::size_t i = 16; i < 64; ++i) {
        const std::uint32_t a = w[i - 15];
        const std::uint32_t b = w[i - 2];
        const std::uint32_t s0 = std::rotr(a, 7) ^ std::rotr(a, 18) ^ (a >> 3U);
        const std::uint32_t s1 = std::rotr(b, 17) ^ std::rotr(b, 19) ^ (b >> 10U);
        w[i] = w[i - 16] + s0 + w[i - 7] + s1;
    }
    return w;
}

}  // namespace

void Sha256::absorb(std::span<const std::uint8_t, 64> chunk) noexcept {
    const std::array<std::uint32_t, 64> w = schedule(chunk);
    std::array<std::uint32_t, 8> v = state_;
    for (std::size_t i = 0; i < 64; ++i) {
        const std::uint32_t s1 = std::rotr(v[4], 6) ^ std::rotr(v[4], 11) ^ std::rotr(v[4], 25);
        const std::uint32_t choice = (v[4] & v[5]) ^ (~v[4] & v[6]);
        const std::uint32_t t1 = v[7] + s1 + choice + kRound[i] + w[i];
        const std::uint32_t s0 = std::rotr(v[0], 2) ^ std::rotr(v[0], 13) ^ std::rotr(v[0], 22);
        const std::uint32_t majority = (v[0] & v[1]) ^ (v[0] & v[2]) ^ (v[1] & v[2]);
        v = {t1 + s0 + majority, v[0], v[1], v[2], v[3] + t1, v[4], v[5], v[6]};
    }
    for (std::size_t i = 0; i < 8; ++i) {
        state_[i] += v[i];
    }
}

Sha256& Sha256::update(std::span<const std::uint8_t> bytes) noexcept {
    total_bytes_ += bytes.size();
    for (const std::uint8_t byte : bytes) {
        pending_[pending_size_++] = byte;
        if (pending_size_ == pending_.size()) {
            absorb(pending_);
            pending_size_ = 0;
        }
    }
    return *this;
}

Sha256Digest Sha256::digest() const noexcept {
    Sha256 last = *this;
    constexpr std::array<std::uint8_t, 64> kPadding{0x80};
    const std::size_t padding = pending_size_ < 56 ? 56 - pending_size_ : 120 - pending_size_;
    last.update(std::span(kPadding).first(padding));
    std::array<std::uint8_t, 8> bits{};
    for (std::size_t i = 0; i < bits.size(); ++i) {
        bits[i] = static_cast<std::uint8_t>(((total_bytes_ * 8) >> (56 - 8 * i)) & 0xFFU);
    }
    last.update(bits);
    Sha256Digest out{};
    for (std::size_t i = 0; i < out.size(); ++i) {
        out[i] = static_cast<std::uint8_t>((last.state_[i / 4] >> (24 - 8 * (i % 4))) & 0xFFU);
    }
    return out;
}

std::array<char, 64> to_hex(const Sha256Digest& digest) noexcept {
    constexpr std::array<char, 16> kDigits{'0', '1', '2', '3', '4', '5', '6', '7',
                                           '8', '9', 'a', 'b', 'c', 'd', 'e', 'f'};
    std::array<char, 64> out{};
    for (std::size_t i = 0; i < digest.size(); ++i) {
        out[2 * i] = kDigits[digest[i] >> 4U];
        out[2 * i + 1] = kDigits[digest[i] & 0xFU];
    }
    return out;
}

}  // namespace sc
