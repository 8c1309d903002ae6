// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace sc::host {

/// A message of a capture, as our own decoder reads it.
struct CapturedMessage {
    std::size_t packet = 0;  ///< the one that completes it, from 1
    std::int64_t time_ns = 0;
    bool to_controller = false;
    std::uint8_t id = 0;
    std::string name;  ///< empty: no message of this schema
    std::uint16_t counter = 0;
    std::uint8_t minor = 0;         ///< newest minor version whose schema its checksum fits
    std::uint32_t lost = 0;         ///< messages missing before it, by the counter
    bool repeated = false;          ///< by the counter: a receiver drops it
    bool malformed = false;         ///< right checksum, but its fields do not come out; no fields then
    std::string tag;                ///< hex, of a sealed message; who has not the key cannot tell whether it is right
    nlohmann::ordered_json fields;  ///< numbers, arrays of them, bytes as text in hex; a double that is none as text
};

/// What else one direction had.
struct CaptureLosses {
    std::uint32_t frames_bad = 0;        ///< cut or spoilt frames of a serial link
    std::uint32_t checks_failed = 0;     ///< whole, but with a wrong checksum or no message
    std::uint32_t gaps = 0;              ///< in the sequence of CAN frames
    std::uint32_t messages_dropped = 0;  ///< begun on CAN and not completed
    std::uint32_t frames_repeated = 0;   ///< on CAN
};

struct DecodedCapture {
    std::string kind;  ///< "serial", "can"
    std::size_t packets = 0;
    std::vector<CapturedMessage> messages;
    CaptureLosses to_host;
    CaptureLosses to_controller;
};

/// Decodes a capture with the link's own code. Throws InputError for a file that is no capture.
[[nodiscard]] DecodedCapture decode_capture(const std::filesystem::path& file);

/// One object: `kind`, `packets`, `messages[]`, `to_host`, `to_controller`.
[[nodiscard]] nlohmann::ordered_json to_json(const DecodedCapture& capture);
/// One line a message.
[[nodiscard]] std::string text_of(const DecodedCapture& capture);

}  // namespace sc::host
