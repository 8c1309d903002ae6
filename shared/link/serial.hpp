// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "shared/link/cobs.hpp"
#include "shared/link/codec.hpp"

/// Messages over a serial line: one COBS frame each.

namespace sc::link {

inline constexpr std::size_t kSerialCapacity = cobs_capacity(kMessageCapacity);

/// Encodes and frames one message. Bytes written to the start of `out`, or 0 when they do not fit.
template <class Message>
[[nodiscard]] constexpr std::size_t encode_serial(const Message& message, std::uint16_t counter,
                                                  std::span<std::uint8_t> out,
                                                  std::uint8_t minor = kProtocolMinor) noexcept {
    // Not zeroed: that took as long as the rest on a core whose memset goes byte by byte.
    std::array<std::uint8_t, kMessageCapacity> plain;  // NOLINT(cppcoreguidelines-pro-type-member-init): written first
    if consteval {
        plain.fill(0);
    }
    const std::size_t size = encode_message(message, counter, plain, minor);
    return size == 0 ? 0 : cobs_encode(std::span(plain).first(size), out);
}

/// The receiving half: bytes in any portions, messages with a right checksum out.
class SerialReceiver {
public:
    /// Calls `on_message(const Envelope&)` for each, in order; the envelope is valid during the call.
    template <class OnMessage>
    constexpr void receive(std::span<const std::uint8_t> bytes, OnMessage&& on_message) {
        while (!bytes.empty()) {
            const auto frame = decoder_.take(bytes);
            if (!frame) {
                continue;
            }
            const std::optional<Envelope> envelope = open_message(*frame, minor_);
            if (envelope) {
                on_message(*envelope);
            } else {
                ++checks_failed_;
            }
        }
    }
    /// The minor version that both sides have agreed upon; the newest until then.
    constexpr void set_minor(std::uint8_t minor) noexcept { minor_ = minor; }
    /// Frames dropped: cut, too long, too short, or with a wrong checksum.
    [[nodiscard]] constexpr std::uint32_t frames_bad() const noexcept { return decoder_.frames_bad() + checks_failed_; }

private:
    CobsDecoder<kMessageCapacity> decoder_;
    std::uint32_t checks_failed_ = 0;
    std::uint8_t minor_ = kProtocolMinor;
};

}  // namespace sc::link
