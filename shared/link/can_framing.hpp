// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "shared/link/codec.hpp"

/// Messages over CAN, classic (8 bytes a frame) and FD (64). Each frame begins with a byte
///
///     start (0x80) | end (0x40) | sequence (6 bits)
///
/// and a start frame has the message's length as its second byte, because an FD frame can only have certain sizes and
/// is padded with zeros. The sequence counts all frames of one direction, modulo 64; a message has at most 36 frames,
/// so a lost frame always shows. A message of 247 bytes takes 36 classic frames or 4 FD frames.

namespace sc::link {

struct LinkCanFrame {
    std::uint32_t id = 0;
    std::uint8_t size = 0;  ///< bytes of data; a legal DLC length
    std::array<std::uint8_t, 64> data{};
    bool fd = false;
    bool operator==(const LinkCanFrame&) const noexcept = default;
};

namespace can_bits {
inline constexpr std::uint8_t kStart = 0x80;
inline constexpr std::uint8_t kEnd = 0x40;
inline constexpr std::uint8_t kSequence = 0x3F;
}  // namespace can_bits

/// Smallest size at or above `size` that a frame can have (FD: 0..8, 12, 16, 20, 24, 32, 48, 64). 64 for more.
[[nodiscard]] std::uint8_t legal_can_size(std::size_t size) noexcept;

/// Cuts messages into frames. One object a direction: it carries the sequence from message to message.
class CanSegmenter {
public:
    CanSegmenter(std::uint32_t id, bool fd) noexcept : id_(id), fd_(fd) {}

    /// Takes a copy of the message. False, and nothing taken, when the message is empty or too long, or frames of the
    /// last one are still to be fetched.
    [[nodiscard]] bool begin(std::span<const std::uint8_t> message) noexcept;
    /// The next frame; false when there is none.
    [[nodiscard]] bool next(LinkCanFrame& out) noexcept;
    [[nodiscard]] bool busy() const noexcept { return place_ < size_; }

private:
    std::uint32_t id_;
    bool fd_;
    std::uint8_t sequence_ = 0;
    std::array<std::uint8_t, kMessageCapacity> message_{};
    std::size_t size_ = 0;
    std::size_t place_ = 0;
};

/// Puts frames together again. A gap, a size that does not fit or a missing start drops the message and is counted; the
/// next start frame begins anew. A frame that comes twice in a row is ignored.
class CanReassembler {
public:
    /// The message that this frame completes, if it does; valid until the next call. Its checksum is not looked at.
    [[nodiscard]] std::optional<std::span<const std::uint8_t>> push(const LinkCanFrame& frame) noexcept;

    /// Messages begun and not completed, and stretches of frames without a start.
    [[nodiscard]] std::uint32_t messages_dropped() const noexcept { return messages_dropped_; }
    /// Breaks in the sequence of frames.
    [[nodiscard]] std::uint32_t gaps() const noexcept { return gaps_; }
    [[nodiscard]] std::uint32_t frames_repeated() const noexcept { return frames_repeated_; }

private:
    enum class State : std::uint8_t { idle, inside, skipping };

    bool check_sequence(std::uint8_t header) noexcept;
    void drop() noexcept;
    bool start(std::span<const std::uint8_t>& body) noexcept;
    std::optional<std::span<const std::uint8_t>> take(std::span<const std::uint8_t> body, bool last,
                                                      bool may_pad) noexcept;

    std::array<std::uint8_t, kMessageCapacity> message_{};
    std::size_t expected_ = 0;
    std::size_t size_ = 0;
    State state_ = State::idle;
    std::optional<std::uint8_t> last_header_;
    std::uint32_t messages_dropped_ = 0;
    std::uint32_t gaps_ = 0;
    std::uint32_t frames_repeated_ = 0;
};

}  // namespace sc::link
