// SPDX-License-Identifier: Apache-2.0
#include "host/protocol/dissector.hpp"

#include <array>
#include <cstdio>

#include "host/protocol/protocol_table.hpp"
#include "shared/link/can_port.hpp"
#include "shared/link/codec.hpp"
#include "shared/link/seal.hpp"

namespace sc::host {
namespace {

std::string hex(std::uint64_t value, int digits) {
    std::array<char, 24> text{};
    std::snprintf(text.data(), text.size(), "0x%0*llx", digits, static_cast<unsigned long long>(value));
    return text.data();
}

std::string constant(const char* name, const std::string& value, const char* comment) {
    return std::string("local ") + name + " = " + value + " -- " + comment + "\n";
}

std::string constants() {
    return constant("CAN_TO_HOST", hex(link::kCanIdToHost, 3), "identifier of frames") +
           constant("CAN_TO_CONTROLLER", hex(link::kCanIdToController, 3), "identifier of frames") +
           constant("FIRST", hex(link::can_bits::kStart, 2), "in the first byte of a frame") +
           constant("LAST", hex(link::can_bits::kEnd, 2), "in the first byte of a frame") +
           constant("SEQUENCE", hex(link::can_bits::kSequence, 2), "in the first byte of a frame") +
           constant("OVERHEAD", std::to_string(link::kMessageOverhead), "bytes of a message besides its payload") +
           constant("LONGEST", std::to_string(link::kMessageCapacity), "bytes of a message") +
           constant("SEAL", std::to_string(link::kSealTag), "bytes behind the fields of a sealed message") +
           constant("LONGEST_RUN", std::to_string(largest_bytes()), "bytes of a field of type bytes") +
           constant("HELLO", std::to_string(link::Hello::kId), "message that begins a new count") +
           constant("HELLO_REPLY", std::to_string(link::HelloReply::kId), "message that begins a new count") +
           constant("HANDSHAKE_CRC", hex(handshake_crc(), 8), "CRC-32 of the data id of these two");
}

std::string versions() {
    std::string text =
        "-- CRC-32 of each minor version's schema hash, which goes before the message.\nlocal versions = {\n";
    for (const ProtocolVersion& v : protocol_versions()) {
        text += "    { minor = " + std::to_string(v.minor) + ", crc = " + hex(v.crc, 8) + " }, -- schema " +
                hex(v.schema, 16) + "\n";
    }
    return text + "}\n";
}

std::string message_row(const ProtocolMessage& m) {
    std::string text = "    [" + std::to_string(m.id) + "] = { name = \"" + m.name +
                       "\", to_controller = " + (m.to_controller ? "true" : "false") + ", fields = {\n";
    for (const ProtocolField& f : m.fields) {
        text += "        { name = \"" + f.name + "\", type = \"" + f.base +
                "\", count = " + std::to_string(f.values()) + " },\n";
    }
    return text + "    } },\n";
}

}  // namespace

std::string wireshark_dissector() {
    std::string text =
        "-- SPDX-License-Identifier: Apache-2.0\n"
        "-- scribecell's link " +
        protocol_version_text() +
        " for Wireshark and tshark. Made by `scribecell protocol --write`; see docs/protocol.md.\n"
        "-- tshark -X lua_script:scribecell.lua -r CAPTURE.pcap -V\n\n" +
        constants() + "\n" + versions() + "\nlocal messages = {\n";
    for (const ProtocolMessage& m : protocol_messages()) {
        text += message_row(m);
    }
    return text + "}\n" + dissector_runtime();
}

}  // namespace sc::host
