// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <variant>

#include "host/bridge/transport.hpp"
#include "shared/link/counter.hpp"
#include "shared/link/later_messages.hpp"
#include "shared/link/messages.hpp"
#include "shared/link/seal.hpp"
#include "shared/link/serial.hpp"

namespace sc::host {

/// What a controller sends.
using CellMessage =
    std::variant<link::HelloReply, link::CommandReply, link::StreamAck, link::JobRefused, link::Status,
                 link::ConfigChunk, link::Position, link::StreamMissing, link::SensorReport, link::ClockReply,
                 link::Telemetry, link::BlackboxChunk, link::Parameters, link::SealChallenge>;

/// What the wire has cost so far; counted, never hidden.
struct WireCounters {
    std::uint64_t sent = 0;               ///< messages
    std::uint64_t received = 0;           ///< messages taken in
    std::uint64_t malformed = 0;          ///< right checksum, but no message of the controller's
    std::uint32_t frames_bad = 0;         ///< dropped for checksum or form
    std::uint32_t messages_lost = 0;      ///< gaps in the controller's message counter
    std::uint32_t messages_repeated = 0;  ///< dropped because they had come before
};

/// Messages over a carrier of bytes: framed, numbered, checked. What does not arrive whole is dropped and counted; to
/// repeat is the client's work.
class Wire {
public:
    /// `transport` must outlive the wire.
    explicit Wire(Transport& transport) noexcept : transport_(&transport) {}

    /// Returns the message's counter.
    template <class Message>
    std::uint16_t send(const Message& message) {
        std::array<std::uint8_t, link::kSerialCapacity> frame{};
        const std::uint16_t counter = next_counter();
        const std::size_t size = encode(message, frame);
        ++counter_;
        ++sent_;
        transport_->send(std::span(frame).first(size));
        return counter;
    }
    /// The counter that the next message will have.
    [[nodiscard]] std::uint16_t next_counter() const noexcept { return static_cast<std::uint16_t>(counter_ & 0xFFFFU); }
    /// The same, not cut to what a message carries.
    [[nodiscard]] std::uint64_t next_position() const noexcept { return counter_; }
    /// Seals what is sent from now on. `first` is the position whose counter the controller was told to go on from.
    void seal(const crypto::CmacKey& key, std::uint64_t first) {
        seal_ = key;
        seal_base_ = first - (first & 0xFFFFU);
    }
    [[nodiscard]] bool sealed() const noexcept { return seal_.has_value(); }
    /// Blocks of AES, or somewhat more, that the controller needs for what was sealed since the last call.
    std::uint64_t take_seal_blocks() noexcept { return std::exchange(seal_blocks_, 0); }
    /// The minor version that both sides have agreed upon; the newest until then.
    void set_minor(std::uint8_t minor) noexcept {
        minor_ = minor;
        receiver_.set_minor(minor);
    }
    [[nodiscard]] std::uint8_t minor() const noexcept { return minor_; }
    /// Waits for bytes or for `until`, and hands on the messages they complete. Returns how many there were (0 also
    /// when only a part of one has come).
    std::size_t receive(HostTime until, const std::function<void(const CellMessage&)>& handle);
    [[nodiscard]] WireCounters counters() const noexcept;

private:
    template <class Message>
    std::size_t encode(const Message& message, std::span<std::uint8_t> frame) {
        if constexpr (link::kSealable<Message>) {
            if (seal_) {
                const std::size_t size = link::encode_sealed(message, counter_ - seal_base_, *seal_, frame, minor_);
                seal_blocks_ += link::seal_blocks(size);
                return size;
            }
        }
        return link::encode_serial(message, next_counter(), frame, minor_);
    }

    Transport* transport_;
    link::SerialReceiver receiver_;
    link::CounterWatch watch_;
    std::uint64_t counter_ = 0;  ///< messages carry its low 16 bits
    std::optional<crypto::CmacKey> seal_;
    std::uint64_t seal_base_ = 0;
    std::uint64_t seal_blocks_ = 0;
    std::uint8_t minor_ = link::kProtocolMinor;
    std::uint64_t sent_ = 0;
    std::uint64_t received_ = 0;
    std::uint64_t malformed_ = 0;
};

}  // namespace sc::host
