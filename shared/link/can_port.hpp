// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/link/can_framing.hpp"
#include "shared/link/cobs.hpp"
#include "shared/link/serial.hpp"

namespace sc::link {

/// Identifiers of the link's frames. The controller's answers pass before the host's items: they open the window.
inline constexpr std::uint32_t kCanIdToHost = 0x100;
inline constexpr std::uint32_t kCanIdToController = 0x200;

/// One end of a CAN link. An endpoint speaks messages as COBS frames on every carrier; this turns them into CAN frames
/// and back, so the endpoint does not know which it is. `Capacity`: bytes that may wait to be sent. No heap; cost
/// proportional to the bytes.
template <std::size_t Capacity>
class CanPort {
public:
    CanPort(std::uint32_t send_id, bool fd) noexcept : segmenter_(send_id, fd) {}

    /// Bytes of whole or part messages to be sent; how many were taken.
    std::size_t push(std::span<const std::uint8_t> bytes) noexcept {
        std::size_t taken = 0;
        while (taken < bytes.size() && size_ < Capacity) {
            ring_[(first_ + size_) % Capacity] = bytes[taken];
            ++size_;
            ++taken;
        }
        return taken;
    }
    /// The next frame to be sent; false when there is none.
    [[nodiscard]] bool next(LinkCanFrame& out) noexcept {
        while (!segmenter_.busy() && size_ > 0) {
            const std::uint8_t byte = ring_[first_];
            first_ = (first_ + 1) % Capacity;
            --size_;
            if (const auto message = unframer_.push(byte)) {
                (void)segmenter_.begin(*message);
            }
        }
        return segmenter_.next(out);
    }
    /// A frame has come. The message that it completes, as COBS bytes at the start of `out` (kSerialCapacity is
    /// enough); 0 when it completes none.
    [[nodiscard]] std::size_t take(const LinkCanFrame& frame, std::span<std::uint8_t> out) noexcept {
        const auto message = reassembler_.push(frame);
        return message ? cobs_encode(*message, out) : 0;
    }
    [[nodiscard]] const CanReassembler& reassembler() const noexcept { return reassembler_; }

private:
    CanSegmenter segmenter_;
    CanReassembler reassembler_;
    CobsDecoder<kMessageCapacity> unframer_;
    std::array<std::uint8_t, Capacity> ring_{};
    std::size_t first_ = 0;
    std::size_t size_ = 0;
};

}  // namespace sc::link
