// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sc::host {

struct ProtocolField {
    std::string name;
    std::string base;       ///< as the schema names it: "u8" … "i64", "f64", "bytes"
    std::size_t count = 0;  ///< of an array; 0: one value

    [[nodiscard]] bool is_bytes() const { return base == "bytes"; }
    [[nodiscard]] bool is_float() const { return base.front() == 'f'; }
    [[nodiscard]] bool is_signed() const { return base.front() != 'u'; }
    /// Of one value; not for bytes.
    [[nodiscard]] std::size_t bits() const { return static_cast<std::size_t>(std::stoul(base.substr(1))); }
    [[nodiscard]] std::size_t values() const { return count == 0 ? 1 : count; }
};

struct ProtocolMessage {
    std::uint8_t id = 0;
    std::string name;
    bool to_controller = false;
    std::uint8_t since = 0;           ///< minor version
    std::size_t largest_payload = 0;  ///< bytes
    std::vector<ProtocolField> fields;
};

/// All messages of the link, in the order of the schema's lists.
[[nodiscard]] const std::vector<ProtocolMessage>& protocol_messages();

/// What a message's checksum begins with: the CRC-32 of the data id, to be gone on with.
struct ProtocolVersion {
    std::uint8_t minor = 0;
    std::uint64_t schema = 0;
    std::uint32_t crc = 0;
};
/// Newest first.
[[nodiscard]] std::vector<ProtocolVersion> protocol_versions();
/// The same of hello and hello_reply, whatever the version.
[[nodiscard]] std::uint32_t handshake_crc();

/// "1.1"
[[nodiscard]] std::string protocol_version_text();

/// Largest length of a `bytes` field.
[[nodiscard]] std::size_t largest_bytes() noexcept;

}  // namespace sc::host
