// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

/// Consistent overhead byte stuffing: a frame's zeros are replaced, so that 0x00 on a serial line is always the end of
/// a frame and a receiver that has lost its place finds it again at the next one. One byte more per 254, plus the end.

namespace sc::link {

/// Longest encoding of `size` bytes, with the delimiter.
[[nodiscard]] constexpr std::size_t cobs_capacity(std::size_t size) noexcept { return size + size / 254 + 2; }

/// Encodes one frame and its delimiter into `out` (which must not overlap `frame`). Its size, or 0 when it does not fit
/// (`out` is then unspecified).
[[nodiscard]] constexpr std::size_t cobs_encode(std::span<const std::uint8_t> frame,
                                                std::span<std::uint8_t> out) noexcept {
    constexpr std::uint8_t kFullGroup = 0xFF;
    std::size_t code_at = 0;
    std::size_t size = 1;
    std::uint8_t code = 1;
    for (const std::uint8_t byte : frame) {
        if (code == kFullGroup) {
            if (size >= out.size()) {
                return 0;
            }
            out[code_at] = code;
            code_at = size++;
            code = 1;
        }
        if (size >= out.size()) {
            return 0;
        }
        if (byte == 0) {
            out[code_at] = code;
            code_at = size++;
            code = 1;
        } else {
            out[size++] = byte;
            ++code;
        }
    }
    if (size >= out.size()) {
        return 0;
    }
    out[code_at] = code;
    out[size++] = 0;
    return size;
}

/// Takes a serial line byte by byte. Garbage costs the frame it falls into, never a later one.
template <std::size_t Capacity>
class CobsDecoder {
    static constexpr std::uint8_t kFullGroup = 0xFF;

public:
    /// Takes bytes off the front of `bytes`, up to the end of a frame if there is one; the frame then, valid until the
    /// next call. Some ten operations a byte.
    [[nodiscard]] constexpr std::optional<std::span<const std::uint8_t>> take(
        std::span<const std::uint8_t>& bytes) noexcept {
        // Locals: a byte may alias any member, which would then be stored and loaded at every step.
        std::size_t size = size_;
        std::uint8_t left = left_in_group_;
        std::size_t taken = 0;
        bool ended = false;
        while (taken < bytes.size() && !ended) {
            const std::uint8_t byte = bytes[taken++];
            ended = byte == 0;
            const bool in_group = left > 0;
            const bool store = in_group || (begun_ && !after_full_group_);
            if (!ended && store && size < Capacity) {
                frame_[size++] = in_group ? byte : std::uint8_t{0};
            } else {
                too_long_ = too_long_ || (!ended && store);
            }
            if (in_group) {
                left = static_cast<std::uint8_t>(left - (ended ? 0 : 1));
            } else if (!ended) {
                begun_ = true;
                after_full_group_ = byte == kFullGroup;
                left = static_cast<std::uint8_t>(byte - 1);
            }
        }
        size_ = size;
        left_in_group_ = left;
        bytes = bytes.subspan(taken);
        return ended ? end_frame() : std::nullopt;
    }
    /// The frame that this byte ends, if it does; valid until the next call.
    [[nodiscard]] constexpr std::optional<std::span<const std::uint8_t>> push(std::uint8_t byte) noexcept {
        std::span<const std::uint8_t> one(&byte, 1);
        return take(one);
    }
    /// Frames dropped because they were cut or longer than the capacity.
    [[nodiscard]] constexpr std::uint32_t frames_bad() const noexcept { return frames_bad_; }

private:
    constexpr std::optional<std::span<const std::uint8_t>> end_frame() noexcept {
        const bool whole = begun_ && left_in_group_ == 0 && !too_long_;
        const bool bad = begun_ && !whole;
        const std::size_t size = size_;
        frames_bad_ += bad ? 1U : 0U;
        begun_ = false;
        after_full_group_ = false;
        too_long_ = false;
        left_in_group_ = 0;
        size_ = 0;
        if (!whole) {
            return std::nullopt;
        }
        return std::span<const std::uint8_t>(frame_).first(size);
    }

    std::array<std::uint8_t, Capacity> frame_{};
    std::size_t size_ = 0;
    std::uint32_t frames_bad_ = 0;
    std::uint8_t left_in_group_ = 0;
    bool begun_ = false;
    bool after_full_group_ = false;
    bool too_long_ = false;
};

}  // namespace sc::link
