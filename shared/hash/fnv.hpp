// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

/// FNV-1a, 64 bits: a short hash for identity (schema, job), at compile time if wanted. No protection against malice.

namespace sc {

class Fnv1a64 {
public:
    constexpr Fnv1a64() noexcept = default;
    /// Goes on from the value of an earlier one.
    constexpr explicit Fnv1a64(std::uint64_t state) noexcept : state_(state) {}
    constexpr Fnv1a64& update(std::span<const std::uint8_t> bytes) noexcept {
        for (const std::uint8_t byte : bytes) {
            add(byte);
        }
        return *this;
    }
    constexpr Fnv1a64& update(std::string_view text) noexcept {
        for (const char character : text) {
            add(static_cast<std::uint8_t>(character));
        }
        return *this;
    }
    /// One step for a whole number, where `update` takes one a byte: another hash, for what is hashed in a hurry.
    constexpr Fnv1a64& update_word(std::uint32_t word) noexcept {
        state_ = (state_ ^ word) * kPrime;
        return *this;
    }
    [[nodiscard]] constexpr std::uint64_t value() const noexcept { return state_; }

private:
    constexpr void add(std::uint8_t byte) noexcept { state_ = (state_ ^ byte) * kPrime; }

    static constexpr std::uint64_t kPrime = 0x100000001B3ULL;
    std::uint64_t state_ = 0xCBF29CE484222325ULL;
};

[[nodiscard]] constexpr std::uint64_t fnv1a64(std::string_view text) noexcept { return Fnv1a64{}.update(text).value(); }
[[nodiscard]] constexpr std::uint64_t fnv1a64(std::span<const std::uint8_t> bytes) noexcept {
    return Fnv1a64{}.update(bytes).value();
}

}  // namespace sc
