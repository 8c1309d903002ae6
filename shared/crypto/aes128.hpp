// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace sc::crypto {

using Block = std::array<std::uint8_t, 16>;
using Key = std::array<std::uint8_t, 16>;

/// AES with a key of 128 bits, encryption alone (FIPS 197). No heap; any context. A block costs some 700 instructions
/// of a Cortex-M7, a key 400. Look-ups depend on the data: no defence against one who times them on the same core.
class Aes128 {
public:
    /// Without a key: encrypts nothing useful.
    Aes128() = default;
    explicit Aes128(const Key& key) noexcept;

    /// In place.
    void encrypt(Block& block) const noexcept;

private:
    std::array<std::uint32_t, 44> round_keys_{};
};

}  // namespace sc::crypto
