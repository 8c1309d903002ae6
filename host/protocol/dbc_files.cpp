// SPDX-License-Identifier: Apache-2.0
#include "host/protocol/dbc_files.hpp"

#include <cstdint>
#include <string>
#include <vector>

#include "host/protocol/protocol_table.hpp"
#include "shared/link/can_port.hpp"
#include "shared/link/codec.hpp"

namespace sc::host {
namespace {

constexpr std::size_t kByte = 8;
/// Of a classic frame: its header, and the length in a first one.
constexpr std::size_t kFrameBytes = 8;
constexpr std::size_t kFirstFrameHead = 2;
constexpr std::uint32_t kExtendedFlag = 0x8000'0000U;

constexpr const char* kNewSymbols =
    "\nNS_ :\n\tCM_\n\tBA_DEF_\n\tBA_\n\tVAL_\n\tSIG_VALTYPE_\n\tBA_DEF_DEF_\n\tSG_MUL_VAL_\n\nBS_:\n\n"
    "BU_: host controller\n\n";

std::string number(std::size_t value) { return std::to_string(value); }

struct Signal {
    std::string name;
    std::string multiplex;  ///< "", "M", "m1", "m1M"
    std::size_t start = 0;  ///< bit, Intel order
    std::size_t bits = 0;
    bool is_signed = false;
    bool is_float = false;
};

/// What a DBC file is made of, in the order in which it must stand.
class Dbc {
public:
    Dbc(std::string title, const std::string& version) : head_("VERSION \"" + version + "\"\n" + kNewSymbols) {
        comments_ = "CM_ \"" + std::move(title) + "\";\n";
    }
    void message(std::uint32_t id, const std::string& name, std::size_t size, bool to_controller) {
        id_ = std::to_string(id);
        receiver_ = to_controller ? "controller" : "host";
        messages_ += (messages_.empty() ? "BO_ " : "\nBO_ ") + id_ + " " + name + ": " + number(size) + " " +
                     (to_controller ? "host" : "controller") + "\n";
    }
    void signal(const Signal& s) {
        messages_ += " SG_ " + s.name + (s.multiplex.empty() ? "" : " " + s.multiplex) + " : " + number(s.start) + "|" +
                     number(s.bits) + "@1" + (s.is_signed ? "-" : "+") + " (1,0) [0|0] \"\" " + receiver_ + "\n";
        if (s.is_float) {
            float_types_ += "SIG_VALTYPE_ " + id_ + " " + s.name + " : " + (s.bits == 32 ? "1" : "2") + ";\n";
        }
    }
    /// `signal` is there while `multiplexer` is `from` to `to`.
    void shown(const std::string& signal, const std::string& multiplexer, std::size_t from, std::size_t to) {
        ranges_ +=
            "SG_MUL_VAL_ " + id_ + " " + signal + " " + multiplexer + " " + number(from) + "-" + number(to) + ";\n";
    }
    void comment(const std::string& text) { comments_ += "CM_ BO_ " + id_ + " \"" + text + "\";\n"; }
    void comment(const std::string& signal, const std::string& text) {
        comments_ += "CM_ SG_ " + id_ + " " + signal + " \"" + text + "\";\n";
    }
    /// What the numbers of a signal are called.
    void values(const std::string& signal, const std::string& names) {
        values_ += "VAL_ " + id_ + " " + signal + names + " ;\n";
    }
    [[nodiscard]] std::string text() const {
        return head_ + messages_ + "\n" + comments_ + "\n" + values_ + float_types_ + "\n" + ranges_;
    }

private:
    std::string head_;
    std::string messages_;
    std::string comments_;
    std::string values_;
    std::string float_types_;
    std::string ranges_;
    std::string id_;
    std::string receiver_;
};

std::string message_names(bool to_controller) {
    std::string names;
    for (const ProtocolMessage& m : protocol_messages()) {
        if (m.to_controller == to_controller) {
            names += " " + number(m.id) + " \"" + m.name + "\"";
        }
    }
    return names;
}

std::string element(const ProtocolField& field, std::size_t i) {
    return field.count == 0 ? field.name : field.name + "_" + number(i);
}

/// Fields of a message that lie whole within the bytes which its first classic frame has left.
void first_frame_fields(Dbc& dbc, const ProtocolMessage& m) {
    constexpr std::size_t kEnd = kFrameBytes * kByte;
    std::size_t bit = (kFirstFrameHead + link::kMessageHead) * kByte;
    const std::string prefix = "m" + number(m.id) + "_";
    for (const ProtocolField& field : m.fields) {
        const std::size_t bits = field.is_bytes() ? kByte : field.bits();
        for (std::size_t i = 0; i < field.values(); ++i) {
            if (bit + bits > kEnd) {
                return;
            }
            const std::string name = prefix + (field.is_bytes() ? field.name + "_size" : element(field, i));
            dbc.signal({name, "m" + number(m.id), bit, bits, !field.is_bytes() && field.is_signed(), field.is_float()});
            dbc.shown(name, "message", m.id, m.id);
            dbc.comment(name, m.name + "." + field.name);
            bit += bits;
        }
        if (field.is_bytes()) {
            return;
        }
    }
}

void frames_of(Dbc& dbc, bool to_controller) {
    const std::string name = to_controller ? "to_controller" : "to_host";
    dbc.message(to_controller ? link::kCanIdToController : link::kCanIdToHost, name, kFrameBytes, to_controller);
    dbc.signal({"sequence", "", 0, 6});
    dbc.signal({"last", "", 6, 1});
    dbc.signal({"first", "M", 7, 1});
    dbc.signal({"length", "m1", kByte, kByte});
    dbc.shown("length", "first", 1, 1);
    dbc.signal({"message", "m1M", 2 * kByte, kByte});
    dbc.shown("message", "first", 1, 1);
    dbc.signal({"counter", "m1", 3 * kByte, 2 * kByte});
    dbc.shown("counter", "first", 1, 1);
    for (std::size_t byte = 1; byte < kFrameBytes; ++byte) {
        dbc.signal({"more_" + number(byte), "m0", byte * kByte, kByte});
        dbc.shown("more_" + number(byte), "first", 0, 0);
    }
    for (const ProtocolMessage& m : protocol_messages()) {
        if (m.to_controller == to_controller) {
            first_frame_fields(dbc, m);
        }
    }
    dbc.comment("A piece of a message. The last one may be shorter than 8 bytes; what is not there has no meaning.");
    dbc.comment("sequence", "counts all frames of this identifier, modulo 64; a step other than 1 is a loss");
    dbc.comment("first", "1: a message begins; 0: it goes on with more_1 to more_7");
    dbc.comment("length", "bytes of the whole message: 3 of head, payload, 4 of checksum");
    dbc.comment("counter", "of messages of this identifier; a step other than 1 is a loss");
    dbc.values("message", message_names(to_controller));
}

/// A run of bytes: its length, and those of its bytes that are there.
void run_of_bytes(Dbc& dbc, const ProtocolField& field, std::size_t bit) {
    const std::string size = field.name + "_size";
    dbc.signal({size, "M", bit, kByte});
    for (std::size_t i = 0; i < largest_bytes(); ++i) {
        const std::string name = field.name + "_" + number(i);
        dbc.signal({name, "m" + number(i + 1), bit + (i + 1) * kByte, kByte});
        dbc.shown(name, size, i + 1, largest_bytes());
    }
}

void whole_message(Dbc& dbc, const ProtocolMessage& m) {
    const std::uint32_t frames = m.to_controller ? link::kCanIdToController : link::kCanIdToHost;
    dbc.message(kExtendedFlag | (frames << kByte) | m.id, m.name, m.largest_payload + link::kMessageOverhead,
                m.to_controller);
    dbc.signal({"message_id", "", 0, kByte});
    dbc.signal({"message_counter", "", kByte, 2 * kByte});
    std::size_t bit = link::kMessageHead * kByte;
    std::string behind;
    for (const ProtocolField& field : m.fields) {
        if (field.is_bytes()) {
            run_of_bytes(dbc, field, bit);
            behind = field.name;
            break;
        }
        for (std::size_t i = 0; i < field.values(); ++i) {
            dbc.signal({element(field, i), "", bit, field.bits(), field.is_signed(), field.is_float()});
            bit += field.bits();
        }
    }
    const std::string since = m.since == 0 ? "" : " Since minor version " + number(m.since) + ".";
    if (behind.empty()) {
        dbc.signal({"message_crc", "", bit, 4 * kByte});
        dbc.comment("Message " + number(m.id) + ", put together from its frames." + since);
    } else {
        dbc.comment("Message " + number(m.id) + ", put together from its frames." + since + " What stands behind " +
                    behind + ", the checksum at last, has no fixed place.");
    }
}

}  // namespace

std::string frames_dbc() {
    Dbc dbc("scribecell's link " + protocol_version_text() +
                " over classic CAN: its frames. Made by `scribecell protocol --write`; see docs/protocol.md.",
            protocol_version_text());
    frames_of(dbc, false);
    frames_of(dbc, true);
    return dbc.text();
}

std::string messages_dbc() {
    Dbc dbc("scribecell's link " + protocol_version_text() +
                ": its messages, put together from their frames. No frame has these identifiers. Made by "
                "`scribecell protocol --write`; see docs/protocol.md.",
            protocol_version_text());
    for (const ProtocolMessage& m : protocol_messages()) {
        whole_message(dbc, m);
    }
    return dbc.text();
}

}  // namespace sc::host
