// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "shared/hash/crc.hpp"
#include "shared/link/messages.hpp"
#include "shared/link/schema.hpp"
#include "shared/wire/bytes.hpp"

/// A message as bytes, the same on every carrier:
///
///     id u8 | counter u16 | payload | crc u32
///
/// The CRC-32 covers a data id of 8 bytes that is not sent, then everything from id to the payload's end. The data id
/// is the hash of the agreed schema: bytes of a peer that means something else by them fail the check. Hello and
/// HelloReply have a data id that never changes, so that two peers of different schema can still tell each other so.
///
/// No heap; any context; cost proportional to the bytes.

namespace sc::link {

inline constexpr std::size_t kMessageHead = 3;
inline constexpr std::size_t kMessageOverhead = kMessageHead + 4;
inline constexpr std::size_t kMessageCapacity = kPayloadCapacity + kMessageOverhead;

/// A message whose length and checksum are right; its payload has not been looked at. Points into the received bytes.
struct Envelope {
    std::uint8_t id = 0;
    std::uint16_t counter = 0;
    std::span<const std::uint8_t> payload;
};

namespace codec_detail {

constexpr Crc32 crc_after(std::uint64_t data_id) noexcept {
    std::array<std::uint8_t, 8> bytes{};
    ByteWriter(bytes).put(data_id);
    return Crc32{}.update(bytes);
}
/// Of each minor version.
inline constexpr std::array<Crc32, kSchemaHashes.size()> kSchemaCrc = [] {
    std::array<Crc32, kSchemaHashes.size()> all{};
    for (std::size_t minor = 0; minor < all.size(); ++minor) {
        all[minor] = crc_after(kSchemaHashes[minor]);
    }
    return all;
}();
inline constexpr Crc32 kHandshakeCrc = crc_after(fnv1a64("scribecell handshake"));

[[nodiscard]] constexpr std::uint32_t message_crc(std::span<const std::uint8_t> id_to_payload,
                                                  std::uint8_t minor) noexcept {
    const bool handshake = id_to_payload[0] == Hello::kId || id_to_payload[0] == HelloReply::kId;
    Crc32 crc = handshake ? kHandshakeCrc : kSchemaCrc[minor];
    return crc.update(id_to_payload).value();
}

template <WireNumber T>
constexpr void put_field(ByteWriter& out, const T& value) noexcept {
    out.put(value);
}
template <class T, std::size_t N>
constexpr void put_field(ByteWriter& out, const std::array<T, N>& values) noexcept {
    for (const T& value : values) {
        out.put(value);
    }
}
constexpr void put_field(ByteWriter& out, const Bytes& bytes) noexcept {
    if (bytes.size > bytes.data.size()) {
        out.fail();
        return;
    }
    out.put(bytes.size);
    out.put_bytes(std::span(bytes.data).first(bytes.size));
}

template <WireNumber T>
constexpr void get_field(ByteReader& in, T& value) noexcept {
    value = in.get<T>();
}
template <class T, std::size_t N>
constexpr void get_field(ByteReader& in, std::array<T, N>& values) noexcept {
    for (T& value : values) {
        value = in.get<T>();
    }
}
constexpr void get_field(ByteReader& in, Bytes& bytes) noexcept {
    bytes.size = in.get<std::uint8_t>();
    if (bytes.size > bytes.data.size()) {
        in.fail();
        return;
    }
    const std::span<const std::uint8_t> data = in.get_bytes(bytes.size);
    std::copy(data.begin(), data.end(), bytes.data.begin());
}

struct FieldWriter {
    ByteWriter& out;
    template <class T>
    constexpr void operator()(std::string_view /*name*/, const T& value) noexcept {
        put_field(out, value);
    }
};
struct FieldReader {
    ByteReader& in;
    template <class T>
    constexpr void operator()(std::string_view /*name*/, T& value) noexcept {
        get_field(in, value);
    }
};

}  // namespace codec_detail

/// Size of the encoded message, at the start of `out`; 0 when it does not fit or a run of bytes claims more than it can
/// hold (`out` is then unspecified). `minor`, here and below: the version that both sides have agreed upon.
template <class Message>
[[nodiscard]] constexpr std::size_t encode_message(const Message& message, std::uint16_t counter,
                                                   std::span<std::uint8_t> out,
                                                   std::uint8_t minor = kProtocolMinor) noexcept {
    static_assert(largest_payload<Message>() <= kPayloadCapacity);
    ByteWriter writer(out);
    writer.put(Message::kId);
    writer.put(counter);
    codec_detail::FieldWriter fields{writer};
    Message::visit(fields, message);
    if (!writer.ok()) {
        return 0;
    }
    writer.put(codec_detail::message_crc(writer.written(), minor));
    return writer.ok() ? writer.size() : 0;
}

/// Checks length and checksum. Nothing for bytes that are no message of this schema.
[[nodiscard]] constexpr std::optional<Envelope> open_message(std::span<const std::uint8_t> bytes,
                                                             std::uint8_t minor = kProtocolMinor) noexcept {
    if (bytes.size() < kMessageOverhead || bytes.size() > kMessageCapacity) {
        return std::nullopt;
    }
    const auto covered = bytes.first(bytes.size() - 4);
    ByteReader crc(bytes.last(4));
    if (crc.get<std::uint32_t>() != codec_detail::message_crc(covered, minor)) {
        return std::nullopt;
    }
    ByteReader head(covered);
    Envelope envelope;
    envelope.id = head.get<std::uint8_t>();
    envelope.counter = head.get<std::uint16_t>();
    envelope.payload = covered.subspan(kMessageHead);
    return envelope;
}

/// False when the payload is shorter or longer than the message's fields; `out` is then unspecified.
template <class Message>
[[nodiscard]] constexpr bool decode_payload(std::span<const std::uint8_t> payload, Message& out) noexcept {
    ByteReader reader(payload);
    codec_detail::FieldReader fields{reader};
    Message::visit(fields, out);
    return reader.exhausted();
}

enum class Dispatch : std::uint8_t { handled, unknown_id, malformed };

namespace codec_detail {

template <class Message, class Handler>
constexpr bool dispatch_one(const Envelope& envelope, Handler& handler, Dispatch& result) {
    if (envelope.id != Message::kId) {
        return false;
    }
    Message message;
    result = decode_payload(envelope.payload, message) ? Dispatch::handled : Dispatch::malformed;
    if (result == Dispatch::handled) {
        handler(message);
    }
    return true;
}

}  // namespace codec_detail

/// Decodes the payload and calls `handler(message)` with the message's own type, for a message of the list.
template <class... Message, class Handler>
constexpr Dispatch dispatch(MessageList<Message...> /*list*/, const Envelope& envelope, Handler&& handler) {
    Dispatch result = Dispatch::unknown_id;
    static_cast<void>((codec_detail::dispatch_one<Message>(envelope, handler, result) || ...));
    return result;
}

}  // namespace sc::link
