// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "shared/link/can_framing.hpp"

/// CAN frames in a stream of bytes, between a host and a simulated cell: laid out like the kernel's can_frame and
/// canfd_frame on a little-endian machine, which a raw CAN socket takes and gives.
///
///     id u32 | size u8 | flags u8 (4: FD) | 0 u16 | data, 8 bytes (classic) or 64 (FD)

namespace sc::link {

inline constexpr std::size_t kCanRecordHead = 8;
inline constexpr std::size_t kCanRecordCapacity = kCanRecordHead + 64;
inline constexpr std::uint8_t kCanRecordFd = 4;

/// Of every record of a carrier: a carrier has frames of one kind only.
[[nodiscard]] constexpr std::size_t can_record_size(bool fd) noexcept { return fd ? kCanRecordCapacity : 16; }

/// `out` must hold can_record_size(frame.fd).
constexpr void put_can_record(const LinkCanFrame& frame, std::span<std::uint8_t> out) noexcept {
    const std::size_t size = can_record_size(frame.fd);
    std::fill_n(out.begin(), size, std::uint8_t{0});
    for (std::size_t i = 0; i < 4; ++i) {
        out[i] = static_cast<std::uint8_t>(frame.id >> (8 * i));
    }
    out[4] = frame.size;
    out[5] = frame.fd ? kCanRecordFd : std::uint8_t{0};
    std::copy_n(frame.data.begin(), std::min<std::size_t>(frame.size, size - kCanRecordHead),
                out.begin() + kCanRecordHead);
}

/// Nothing for bytes that are no frame of that kind. `in` must hold can_record_size(fd).
[[nodiscard]] inline std::optional<LinkCanFrame> get_can_record(std::span<const std::uint8_t> in, bool fd) noexcept {
    LinkCanFrame frame;
    frame.fd = fd;
    for (std::size_t i = 0; i < 4; ++i) {
        frame.id |= static_cast<std::uint32_t>(in[i]) << (8 * i);
    }
    frame.size = in[4];
    const bool is_fd = (in[5] & kCanRecordFd) != 0;
    if (is_fd != fd || frame.size > can_record_size(fd) - kCanRecordHead || legal_can_size(frame.size) != frame.size) {
        return std::nullopt;
    }
    std::copy_n(in.begin() + kCanRecordHead, frame.size, frame.data.begin());
    return frame;
}

}  // namespace sc::link
