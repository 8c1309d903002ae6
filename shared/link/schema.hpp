// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include "shared/hash/fnv.hpp"
#include "shared/link/config.hpp"
#include "shared/link/later_messages.hpp"
#include "shared/link/map_codec.hpp"
#include "shared/link/messages.hpp"
#include "shared/path/block.hpp"

/// The list of all messages and the hash over it. Everything here is worked out at compile time.

namespace sc::link {

template <class... Message>
struct MessageList {
    static constexpr std::size_t size = sizeof...(Message);
};
/// What a controller without a key knows.
using PlainHostMessages =
    MessageList<Hello, Heartbeat, Command, JobOpen, Block, SetCompensation, ConfigRequest, MapChunk, SetMap,
                SetGalvoField, SetPowerCurve, JobResume, PositionRequest, SetGalvoLag, TelemetryRequest,
                BlackboxRequest, StoreParameters, ParametersRequest, SetSurface, CheckSeating, SensorsRequest>;
/// What opens a sealed session.
using SealMessages = MessageList<SealRequest, SealHello>;
template <class... A, class... B>
constexpr MessageList<A..., B...> joined(MessageList<A...> /*a*/, MessageList<B...> /*b*/) noexcept {
    return {};
}
using HostMessages = decltype(joined(PlainHostMessages{}, SealMessages{}));
using CellMessages =
    MessageList<HelloReply, CommandReply, StreamAck, JobRefused, Status, ConfigChunk, Position, StreamMissing,
                ClockReply, Telemetry, BlackboxChunk, Parameters, SensorReport, SealChallenge>;

/// Calls `f(message)` with a default one of each, in order of the list.
template <class... Message, class F>
constexpr void for_each_message(MessageList<Message...> /*list*/, F&& f) {
    (f(Message{}), ...);
}

/// A field's type as the schema names it: "u16" and 0, or "i32" and 4 for an array of four.
struct FieldType {
    std::string_view base;
    std::size_t count = 0;
    std::size_t largest_bytes = 0;  ///< on the wire
};

template <class T>
struct FieldTypeOf;
template <>
struct FieldTypeOf<std::uint8_t> {
    static constexpr FieldType value{"u8", 0, 1};
};
template <>
struct FieldTypeOf<std::uint16_t> {
    static constexpr FieldType value{"u16", 0, 2};
};
template <>
struct FieldTypeOf<std::uint32_t> {
    static constexpr FieldType value{"u32", 0, 4};
};
template <>
struct FieldTypeOf<std::uint64_t> {
    static constexpr FieldType value{"u64", 0, 8};
};
template <>
struct FieldTypeOf<std::int32_t> {
    static constexpr FieldType value{"i32", 0, 4};
};
template <>
struct FieldTypeOf<std::int64_t> {
    static constexpr FieldType value{"i64", 0, 8};
};
template <>
struct FieldTypeOf<double> {
    static constexpr FieldType value{"f64", 0, 8};
};
template <>
struct FieldTypeOf<Bytes> {
    static constexpr FieldType value{"bytes", 0, 1 + std::tuple_size_v<decltype(Bytes::data)>};
};
template <class T, std::size_t N>
struct FieldTypeOf<std::array<T, N>> {
    static constexpr FieldType value{FieldTypeOf<T>::value.base, N, N* FieldTypeOf<T>::value.largest_bytes};
};

namespace schema_detail {

struct Hasher {
    Fnv1a64 hash;

    constexpr void number(std::uint64_t value) noexcept {
        std::array<std::uint8_t, 8> bytes{};
        ByteWriter(bytes).put(value);
        hash.update(bytes);
    }
    constexpr void text(std::string_view value) noexcept {
        number(value.size());
        hash.update(value);
    }
    template <class T>
    constexpr void operator()(std::string_view name, const T& /*value*/) noexcept {
        text(name);
        text(FieldTypeOf<T>::value.base);
        number(FieldTypeOf<T>::value.count);
    }
    template <class Message>
    constexpr void message(const Message& m) noexcept {
        number(Message::kId);
        text(Message::kName);
        Message::visit(*this, m);
    }
};

struct Sizer {
    std::size_t bytes = 0;
    template <class T>
    constexpr void operator()(std::string_view /*name*/, const T& /*value*/) noexcept {
        bytes += FieldTypeOf<T>::value.largest_bytes;
    }
};

}  // namespace schema_detail

/// Of what messages carry as bytes.
struct LayoutVersions {
    std::uint16_t block_grammar = kBlockGrammarVersion;
    std::uint16_t config = kConfigVersion;
    std::uint16_t map = kMapVersion;
};

/// A minor version keeps the block grammar that it came with: later ones only add to it.
[[nodiscard]] constexpr LayoutVersions layouts_of(std::uint8_t minor) noexcept {
    LayoutVersions layouts;
    if (minor < 2) {
        layouts.block_grammar = 3;
    }
    return layouts;
}

/// Hash over the number, name, field names and field types of every message that a minor version has, the protocol's
/// major version, and the versions of the block grammar, of the machine configuration's layout and of the axis map's.
[[nodiscard]] constexpr std::uint64_t schema_hash(std::uint8_t minor, const LayoutVersions& layouts) noexcept {
    schema_detail::Hasher hasher;
    hasher.number(kProtocolMajor);
    hasher.number(layouts.block_grammar);
    hasher.number(layouts.config);
    hasher.number(layouts.map);
    const auto add = [&hasher, minor]<class Message>(const Message& m) noexcept {
        if (since<Message>() <= minor) {
            hasher.message(m);
        }
    };
    for_each_message(HostMessages{}, add);
    for_each_message(CellMessages{}, add);
    return hasher.hash.value();
}
[[nodiscard]] constexpr std::uint64_t schema_hash(std::uint8_t minor = kProtocolMinor) noexcept {
    return schema_hash(minor, layouts_of(minor));
}
inline constexpr std::uint64_t kSchemaHash = schema_hash(kProtocolMinor);

/// Hash of each minor version, from 0.
inline constexpr std::array<std::uint64_t, kProtocolMinor + 1> kSchemaHashes = [] {
    std::array<std::uint64_t, kProtocolMinor + 1> hashes{};
    for (std::size_t minor = 0; minor < hashes.size(); ++minor) {
        hashes[minor] = schema_hash(static_cast<std::uint8_t>(minor));
    }
    return hashes;
}();
static_assert(schema_hash(0, {.block_grammar = 2, .config = 3, .map = 1}) == 0xA37B'BB52'C31C'7BBCULL,
              "the messages of minor version 0 must stay as they were");
static_assert(schema_hash(1, {.block_grammar = 3, .config = 5, .map = 1}) == 0xBFD3'E071'DC89'3732ULL,
              "the messages of minor version 1 must stay as they were");
static_assert(schema_hash(2, {.block_grammar = 4, .config = 5, .map = 1}) == 0x0EB0'85B5'844E'0BC5ULL,
              "the messages of minor version 2 must stay as they were");

/// The minor version that a peer's schema is of; none for a schema that is not known here.
[[nodiscard]] constexpr std::optional<std::uint8_t> minor_of(std::uint64_t schema) noexcept {
    for (std::size_t minor = 0; minor < kSchemaHashes.size(); ++minor) {
        if (kSchemaHashes[minor] == schema) {
            return static_cast<std::uint8_t>(minor);
        }
    }
    return std::nullopt;
}

/// Bytes of the message's longest payload.
template <class Message>
[[nodiscard]] constexpr std::size_t largest_payload() noexcept {
    schema_detail::Sizer sizer;
    const Message message;
    Message::visit(sizer, message);
    return sizer.bytes;
}

}  // namespace sc::link
