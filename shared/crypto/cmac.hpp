// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/crypto/aes128.hpp"

namespace sc::crypto {

/// A key of AES-CMAC (RFC 4493) with what is worked out once: round keys, and the block that ends a message. 192 bytes;
/// one block and one key of AES to make.
class CmacKey {
public:
    CmacKey() = default;
    explicit CmacKey(const Key& key) noexcept;

private:
    friend class CmacRun;
    Aes128 aes_;
    Block subkey_{};  ///< K1
};

/// Blocks of AES that a message of so many bytes takes.
[[nodiscard]] constexpr std::size_t cmac_blocks(std::size_t bytes) noexcept {
    return bytes == 0 ? 1 : (bytes + 15) / 16;
}

/// The CMAC of one message, a block at a time. The key and the message must be the same at each step.
class CmacRun {
public:
    void begin() noexcept {
        state_ = {};
        done_ = 0;
    }
    /// One block of AES. True: that was the last, and `tag` holds.
    bool step(const CmacKey& key, std::span<const std::uint8_t> message) noexcept;
    [[nodiscard]] const Block& tag() const noexcept { return state_; }

private:
    Block state_{};
    std::size_t done_ = 0;  ///< bytes
};

/// At once.
[[nodiscard]] Block cmac(const CmacKey& key, std::span<const std::uint8_t> message) noexcept;

/// Whether a tag, mostly cut short, is the one. Takes as long for any two tags of this length.
[[nodiscard]] constexpr bool same_tag(std::span<const std::uint8_t> tag, const Block& expected) noexcept {
    unsigned different = tag.empty() || tag.size() > expected.size() ? 1U : 0U;
    for (std::size_t i = 0; i < tag.size() && i < expected.size(); ++i) {
        different |= static_cast<unsigned>(tag[i] ^ expected[i]);
    }
    return different == 0;
}

}  // namespace sc::crypto
