// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>

#include "shared/crypto/cmac.hpp"
#include "shared/link/codec.hpp"
#include "shared/link/serial.hpp"

/// Sealed sessions: a host proves with each message that it has the key of the cell (docs/link.md has the whole).
///
/// A sealed message carries, behind its payload and under its CRC, a tag of 8 bytes: the start of the CMAC under the
/// session's key over
///
///     counter u64 | id u8 | payload
///
/// The counter rises with each message; its low 16 bits are the message's own counter, the rest is implied. The
/// session's key and the two proofs are CMACs under the cell's key, over a byte that says which it is and what both
/// sides have said (SealTranscript). No heap; any context.

namespace sc::link {

inline constexpr std::size_t kSealTag = 8;
/// Of a block's items in a sealed session, so that the tag has room in the longest message.
inline constexpr std::size_t kSealedItems = 222;

/// Which of the values under the cell's key it is.
enum class SealUse : std::uint8_t {
    session_key = 1,
    cell_proof = 2,  ///< the controller's, in SealChallenge
    nonce = 3,       ///< what the controller's nonces are drawn by
    host_proof = 4,  ///< in SealHello, over its other fields too
    key_check = 5,   ///< tells whether two keys are the same
};

/// What both sides have said, as bytes: use, both nonces, session, hash of the schema, number of the challenge.
class SealTranscript {
public:
    static constexpr std::size_t kBytes = 1 + 16 + 16 + 4 + 8 + 4;
    static constexpr std::size_t kHelloBytes = kBytes + 2 + 2;

    constexpr void set(const SealRequest& asked, std::span<const std::uint8_t, 16> cell_nonce,
                       std::uint32_t challenge) noexcept {
        ByteWriter out(bytes_);
        out.put(std::uint8_t{0});
        out.put_bytes(asked.nonce);
        out.put_bytes(cell_nonce);
        out.put(asked.session);
        out.put(kSchemaHash);
        out.put(challenge);
    }
    /// What the value of this use is made over.
    [[nodiscard]] constexpr std::span<const std::uint8_t> of(SealUse use) noexcept {
        bytes_[0] = static_cast<std::uint8_t>(use);
        return std::span(bytes_).first(kBytes);
    }
    /// The same of the host's proof.
    [[nodiscard]] constexpr std::span<const std::uint8_t> of(const SealHello& hello) noexcept {
        bytes_[0] = static_cast<std::uint8_t>(SealUse::host_proof);
        ByteWriter out{std::span(bytes_).subspan(kBytes)};
        out.put(hello.heartbeat_timeout_ms);
        out.put(hello.first);
        return bytes_;
    }

private:
    std::array<std::uint8_t, kHelloBytes> bytes_{};
};

/// The first 8 bytes of a CMAC.
[[nodiscard]] constexpr std::array<std::uint8_t, kSealTag> seal_tag(const crypto::Block& cmac) noexcept {
    std::array<std::uint8_t, kSealTag> tag{};
    std::copy_n(cmac.begin(), tag.size(), tag.begin());
    return tag;
}

/// Two keys are the same if this is; says nothing else of a key.
[[nodiscard]] inline std::uint32_t seal_key_check(const crypto::Key& key) noexcept {
    const std::array<std::uint8_t, 1> use{static_cast<std::uint8_t>(SealUse::key_check)};
    const crypto::Block check = crypto::cmac(crypto::CmacKey(key), use);
    return ByteReader(check).get<std::uint32_t>();
}

/// Bytes in front of the payload that the tag covers.
inline constexpr std::size_t kSealHead = 9;
/// Blocks of AES that a message with so long a payload takes.
[[nodiscard]] constexpr std::size_t seal_blocks(std::size_t payload) noexcept {
    return crypto::cmac_blocks(kSealHead + payload);
}

/// A message is sealed unless it opens a session.
template <class Message>
inline constexpr bool kSealable =
    !std::is_same_v<Message, Hello> && !std::is_same_v<Message, SealRequest> && !std::is_same_v<Message, SealHello>;

/// As encode_serial, sealed: bytes written to the start of `out`, or 0 when they do not fit or the message is too long
/// to be sealed.
template <class Message>
[[nodiscard]] std::size_t encode_sealed(const Message& message, std::uint64_t counter, const crypto::CmacKey& key,
                                        std::span<std::uint8_t> out, std::uint8_t minor = kProtocolMinor) noexcept {
    static_assert(kSealable<Message>);
    std::array<std::uint8_t, 8 + kMessageCapacity> covered{};  // counter, id, payload
    ByteWriter payload{std::span(covered).subspan(kSealHead, kPayloadCapacity - kSealTag)};
    codec_detail::FieldWriter fields{payload};
    Message::visit(fields, message);
    if (!payload.ok()) {
        return 0;
    }
    ByteWriter head(covered);
    head.put(counter);
    head.put(Message::kId);
    const auto tag = seal_tag(crypto::cmac(key, std::span(covered).first(kSealHead + payload.size())));
    std::array<std::uint8_t, kMessageCapacity> plain{};
    ByteWriter writer(plain);
    writer.put(Message::kId);
    writer.put(static_cast<std::uint16_t>(counter & 0xFFFFU));
    writer.put_bytes(payload.written());
    writer.put_bytes(tag);
    writer.put(codec_detail::message_crc(writer.written(), minor));
    return writer.ok() ? cobs_encode(writer.written(), out) : 0;
}

}  // namespace sc::link
