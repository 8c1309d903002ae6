// SPDX-License-Identifier: Apache-2.0
// memcpy and memset of this image, in blocks of registers: Debian's newlib is built for size and takes two to three
// times the instructions for the structures of 50 to 300 bytes that the controller copies and clears.
#include <cstddef>
#include <cstdint>

namespace {

// With a size that is known and word alignment the compiler copies through registers and calls nothing; a call would be
// one of these functions to itself, and no test would end.
template <std::size_t kBytes>
[[gnu::always_inline]] inline void copy(std::uint8_t*& to, const std::uint8_t*& from) noexcept {
    __builtin_memcpy(__builtin_assume_aligned(to, 4), __builtin_assume_aligned(from, 4), kBytes);
    to += kBytes;
    from += kBytes;
}

template <std::size_t kBytes>
[[gnu::always_inline]] inline void fill(std::uint8_t*& to, std::uint32_t word) noexcept {
    for (std::size_t i = 0; i < kBytes; i += 4) {
        __builtin_memcpy(__builtin_assume_aligned(to + i, 4), &word, 4);
    }
    to += kBytes;
}

bool aligned(std::uintptr_t address) noexcept { return address % sizeof(std::uint32_t) == 0; }

}  // namespace

// A loop over bytes would be replaced by a call of the function that it is in.
#define SC_NO_PATTERNS [[gnu::optimize("no-tree-loop-distribute-patterns")]]

extern "C" {

SC_NO_PATTERNS void* memcpy(void* __restrict to, const void* __restrict from, std::size_t size) noexcept {
    auto* out = static_cast<std::uint8_t*>(to);
    const auto* in = static_cast<const std::uint8_t*>(from);
    if (aligned(reinterpret_cast<std::uintptr_t>(out) | reinterpret_cast<std::uintptr_t>(in))) {
        for (; size >= 32; size -= 32) {
            copy<32>(out, in);
        }
        if ((size & 16U) != 0) {
            copy<16>(out, in);
        }
        if ((size & 8U) != 0) {
            copy<8>(out, in);
        }
        if ((size & 4U) != 0) {
            copy<4>(out, in);
        }
        size &= 3U;
    }
    for (; size > 0; --size) {
        *out = *in;
        ++out;
        ++in;
    }
    return to;
}

SC_NO_PATTERNS void* memset(void* to, int value, std::size_t size) noexcept {
    auto* out = static_cast<std::uint8_t*>(to);
    const auto byte = static_cast<std::uint8_t>(value);
    if (aligned(reinterpret_cast<std::uintptr_t>(out))) {
        const std::uint32_t word = byte * 0x01010101U;
        for (; size >= 32; size -= 32) {
            fill<32>(out, word);
        }
        if ((size & 16U) != 0) {
            fill<16>(out, word);
        }
        if ((size & 8U) != 0) {
            fill<8>(out, word);
        }
        if ((size & 4U) != 0) {
            fill<4>(out, word);
        }
        size &= 3U;
    }
    for (; size > 0; --size) {
        *out = byte;
        ++out;
    }
    return to;
}

}  // extern "C"
