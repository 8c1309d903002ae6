// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

/// Little-endian numbers to and from bytes, bounded: what does not fit is not written, what is not there reads as 0,
/// and either is remembered. The byte order of the machine does not matter. No heap; callable from any context.

namespace sc {

namespace wire_detail {
template <class T>
struct BitsOf {
    using type = std::make_unsigned_t<T>;
};
template <>
struct BitsOf<double> {
    using type = std::uint64_t;
};
}  // namespace wire_detail

/// What goes on a wire or into a trace as it is: integers, and doubles as their IEEE 754 bits.
template <class T>
concept WireNumber = (std::integral<T> && !std::same_as<T, bool>) || std::same_as<T, double>;

/// Appends to a span that the caller owns.
class ByteWriter {
public:
    constexpr explicit ByteWriter(std::span<std::uint8_t> out) noexcept : out_(out) {}

    template <WireNumber T>
    constexpr void put(T value) noexcept {
        using Bits = typename wire_detail::BitsOf<T>::type;
        if (!reserve(sizeof(T))) {
            return;
        }
        if (!std::is_constant_evaluated() && std::endian::native == std::endian::little) {
            __builtin_memcpy(&out_[size_], &value, sizeof(T));  // one store where the loop takes eight steps a byte
            size_ += sizeof(T);
            return;
        }
        auto bits = std::uint64_t{std::bit_cast<Bits>(value)};
        for (std::size_t i = 0; i < sizeof(T); ++i) {
            out_[size_++] = static_cast<std::uint8_t>(bits & 0xFFU);
            bits >>= 8U;
        }
    }
    constexpr void put_bytes(std::span<const std::uint8_t> bytes) noexcept {
        if (!reserve(bytes.size())) {
            return;
        }
        std::copy(bytes.begin(), bytes.end(), out_.begin() + static_cast<std::ptrdiff_t>(size_));
        size_ += bytes.size();
    }
    /// For a value that cannot be written at all.
    constexpr void fail() noexcept { ok_ = false; }
    /// False as soon as something did not fit; nothing is written after that.
    [[nodiscard]] constexpr bool ok() const noexcept { return ok_; }
    [[nodiscard]] constexpr std::size_t size() const noexcept { return size_; }
    [[nodiscard]] constexpr std::span<const std::uint8_t> written() const noexcept { return out_.first(size_); }

private:
    constexpr bool reserve(std::size_t bytes) noexcept {
        ok_ = ok_ && bytes <= out_.size() - size_;
        return ok_;
    }

    std::span<std::uint8_t> out_;
    std::size_t size_ = 0;
    bool ok_ = true;
};

/// Reads a span from its start.
class ByteReader {
public:
    constexpr explicit ByteReader(std::span<const std::uint8_t> in) noexcept : in_(in) {}

    template <WireNumber T>
    [[nodiscard]] constexpr T get() noexcept {
        using Bits = typename wire_detail::BitsOf<T>::type;
        if (!take(sizeof(T))) {
            return T{};
        }
        if (!std::is_constant_evaluated() && std::endian::native == std::endian::little) {
            T value{};
            __builtin_memcpy(&value, &in_[place_ - sizeof(T)], sizeof(T));
            return value;
        }
        std::uint64_t bits = 0;
        for (std::size_t i = sizeof(T); i > 0; --i) {
            bits = (bits << 8U) | in_[place_ - sizeof(T) + i - 1];
        }
        return std::bit_cast<T>(static_cast<Bits>(bits));
    }
    /// The next `bytes` bytes; empty when there are not so many.
    [[nodiscard]] constexpr std::span<const std::uint8_t> get_bytes(std::size_t bytes) noexcept {
        if (!take(bytes)) {
            return {};
        }
        return in_.subspan(place_ - bytes, bytes);
    }
    /// For a value that may not be.
    constexpr void fail() noexcept { ok_ = false; }
    /// False as soon as something was asked for that was not there.
    [[nodiscard]] constexpr bool ok() const noexcept { return ok_; }
    [[nodiscard]] constexpr std::size_t remaining() const noexcept { return in_.size() - place_; }
    /// Everything was there and everything was read.
    [[nodiscard]] constexpr bool exhausted() const noexcept { return ok_ && remaining() == 0; }

private:
    constexpr bool take(std::size_t bytes) noexcept {
        ok_ = ok_ && bytes <= remaining();
        place_ += ok_ ? bytes : 0;
        return ok_;
    }

    std::span<const std::uint8_t> in_;
    std::size_t place_ = 0;
    bool ok_ = true;
};

}  // namespace sc
