// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "shared/crypto/aes128.hpp"

namespace sc::crypto {

inline constexpr std::size_t kKeyDigits = 32;

/// A digit of a number in hex, either case; none for any other character.
[[nodiscard]] constexpr std::optional<std::uint8_t> hex_digit(char c) noexcept {
    if (c >= '0' && c <= '9') {
        return static_cast<std::uint8_t>(c - '0');
    }
    const char lower = static_cast<char>(c | 0x20);
    if (lower >= 'a' && lower <= 'f') {
        return static_cast<std::uint8_t>(lower - 'a' + 10);
    }
    return std::nullopt;
}

/// 32 hex digits, the first byte first, and nothing else.
[[nodiscard]] constexpr std::optional<Key> key_from_text(std::string_view text) noexcept {
    if (text.size() != kKeyDigits) {
        return std::nullopt;
    }
    Key key{};
    for (std::size_t i = 0; i < kKeyDigits; ++i) {
        const auto digit = hex_digit(text[i]);
        if (!digit) {
            return std::nullopt;
        }
        key[i / 2] = static_cast<std::uint8_t>((key[i / 2] << 4U) | *digit);
    }
    return key;
}

}  // namespace sc::crypto
