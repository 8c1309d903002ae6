// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace sc {

using Sha256Digest = std::array<std::uint8_t, 32>;

/// SHA-256 (FIPS 180-4), in steps of any size. 112 bytes of state, no heap; 64 rounds per 64 bytes.
class Sha256 {
public:
    Sha256& update(std::span<const std::uint8_t> bytes) noexcept;
    /// Digest of all bytes so far; the object itself is left as it was, so more may follow.
    [[nodiscard]] Sha256Digest digest() const noexcept;

private:
    void absorb(std::span<const std::uint8_t, 64> chunk) noexcept;

    std::array<std::uint32_t, 8> state_{0x6A09E667U, 0xBB67AE85U, 0x3C6EF372U, 0xA54FF53AU,
                                        0x510E527FU, 0x9B05688CU, 0x1F83D9ABU, 0x5BE0CD19U};
    std::array<std::uint8_t, 64> pending_{};
    std::size_t pending_size_ = 0;
    std::uint64_t total_bytes_ = 0;
};

/// Lower-case hexadecimal digits, without a terminating zero.
[[nodiscard]] std::array<char, 64> to_hex(const Sha256Digest& digest) noexcept;

}  // namespace sc
