// SPDX-License-Identifier: Apache-2.0
#include "host/protocol/capture_decoder.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>

#include "host/formats/capture_file.hpp"
#include "shared/link/can_port.hpp"
#include "shared/link/cobs.hpp"
#include "shared/link/codec.hpp"
#include "shared/link/counter.hpp"
#include "shared/link/seal.hpp"

namespace sc::host {
namespace {

using Json = nlohmann::ordered_json;

std::string hex(std::span<const std::uint8_t> bytes) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::string text;
    for (const std::uint8_t byte : bytes) {
        text += kDigits[byte >> 4U];
        text += kDigits[byte & 0xFU];
    }
    return text;
}

template <class T>
Json json_of(T value) {
    return value;
}
Json json_of(double value) {
    if (std::isfinite(value)) {
        return value;
    }
    return std::isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf";
}

struct FieldJson {
    Json fields = Json::object();

    template <class T>
    void operator()(std::string_view name, const T& value) {
        fields[std::string(name)] = json_of(value);
    }
    template <class T, std::size_t N>
    void operator()(std::string_view name, const std::array<T, N>& values) {
        Json list = Json::array();
        for (const T& value : values) {
            list.push_back(json_of(value));
        }
        fields[std::string(name)] = std::move(list);
    }
    void operator()(std::string_view name, const link::Bytes& value) {
        fields[std::string(name)] = hex(std::span(value.data).first(value.size));
    }
};

/// One direction of a capture.
class Direction {
public:
    Direction(bool to_controller, std::vector<CapturedMessage>& messages, CaptureLosses& losses)
        : to_controller_(to_controller), messages_(&messages), losses_(&losses) {}

    void serial(std::span<const std::uint8_t> bytes, std::size_t packet, std::int64_t time_ns) {
        while (!bytes.empty()) {
            if (const auto frame = decoder_.take(bytes)) {
                message(*frame, packet, time_ns);
            }
        }
        losses_->frames_bad = decoder_.frames_bad();
    }
    void can(const CapturedFrame& captured, std::size_t packet, std::int64_t time_ns) {
        link::LinkCanFrame frame;
        frame.id = captured.id;
        frame.fd = captured.fd;
        frame.size = static_cast<std::uint8_t>(std::min(captured.data.size(), frame.data.size()));
        std::copy_n(captured.data.begin(), frame.size, frame.data.begin());
        if (const auto whole = reassembler_.push(frame)) {
            message(*whole, packet, time_ns);
        }
        losses_->gaps = reassembler_.gaps();
        losses_->messages_dropped = reassembler_.messages_dropped();
        losses_->frames_repeated = reassembler_.frames_repeated();
    }

private:
    void message(std::span<const std::uint8_t> bytes, std::size_t packet, std::int64_t time_ns) {
        std::optional<link::Envelope> envelope;
        std::uint8_t minor = link::kProtocolMinor;
        for (int m = link::kProtocolMinor; m >= 0 && !envelope; --m) {
            minor = static_cast<std::uint8_t>(m);
            envelope = link::open_message(bytes, minor);
        }
        if (!envelope) {
            ++losses_->checks_failed;
            return;
        }
        CapturedMessage& out = messages_->emplace_back();
        out.packet = packet;
        out.time_ns = time_ns;
        out.to_controller = to_controller_;
        out.id = envelope->id;
        out.counter = envelope->counter;
        out.minor = minor;
        count(out);
        const auto fill = [&out]<class Message>(const Message& m) {
            FieldJson fields;
            Message::visit(fields, m);
            out.name = Message::kName;
            out.fields = std::move(fields.fields);
        };
        const link::Dispatch result = to_controller_ ? link::dispatch(link::HostMessages{}, *envelope, fill)
                                                     : link::dispatch(link::CellMessages{}, *envelope, fill);
        out.malformed = result != link::Dispatch::handled;
        const std::size_t size = envelope->payload.size();
        if (to_controller_ && result == link::Dispatch::malformed && size >= link::kSealTag) {
            const std::string tag = hex(envelope->payload.last(link::kSealTag));
            envelope->payload = envelope->payload.first(size - link::kSealTag);
            if (link::dispatch(link::HostMessages{}, *envelope, fill) == link::Dispatch::handled) {
                out.malformed = false;
                out.tag = tag;
            }
        }
    }
    void count(CapturedMessage& out) {
        // A capture may begin anywhere: what was before its first message is not known to be lost.
        const bool opens = out.id == (to_controller_ ? link::Hello::kId : link::HelloReply::kId);
        if (opens || !counted_) {
            watch_.restart(out.counter);
            counted_ = true;
            return;
        }
        const std::uint32_t lost = watch_.lost();
        out.repeated = !watch_.take(out.counter);
        out.lost = watch_.lost() - lost;
    }

    bool to_controller_;
    bool counted_ = false;
    std::vector<CapturedMessage>* messages_;
    CaptureLosses* losses_;
    link::CobsDecoder<link::kMessageCapacity> decoder_;
    link::CanReassembler reassembler_;
    link::CounterWatch watch_;
};

Json to_json(const CaptureLosses& losses) {
    return {{"frames_bad", losses.frames_bad},
            {"checks_failed", losses.checks_failed},
            {"gaps", losses.gaps},
            {"messages_dropped", losses.messages_dropped},
            {"frames_repeated", losses.frames_repeated}};
}

std::string losses_text(const char* name, const CaptureLosses& l) {
    std::array<char, 160> line{};
    std::snprintf(line.data(), line.size(),
                  "%s: %u bad frames, %u failed checks, %u gaps, %u messages dropped, %u frames repeated\n", name,
                  l.frames_bad, l.checks_failed, l.gaps, l.messages_dropped, l.frames_repeated);
    return line.data();
}

}  // namespace

DecodedCapture decode_capture(const std::filesystem::path& file) {
    const CaptureFile capture = read_capture(file);
    DecodedCapture out;
    out.kind = capture.kind == CaptureKind::can ? "can" : "serial";
    out.packets = capture.packets.size();
    Direction to_host(false, out.messages, out.to_host);
    Direction to_controller(true, out.messages, out.to_controller);
    for (std::size_t i = 0; i < capture.packets.size(); ++i) {
        const CapturePacket& packet = capture.packets[i];
        if (capture.kind == CaptureKind::can) {
            const CapturedFrame frame = captured_frame(file, capture, i);
            if (frame.id == link::kCanIdToHost) {
                to_host.can(frame, i + 1, packet.time_ns);
            } else if (frame.id == link::kCanIdToController) {
                to_controller.can(frame, i + 1, packet.time_ns);
            }
        } else if (!packet.bytes.empty()) {
            Direction& direction = packet.bytes[0] == 0 ? to_host : to_controller;
            direction.serial(std::span(packet.bytes).subspan(1), i + 1, packet.time_ns);
        }
    }
    return out;
}

Json to_json(const DecodedCapture& capture) {
    Json messages = Json::array();
    for (const CapturedMessage& m : capture.messages) {
        messages.push_back({{"packet", m.packet},
                            {"time_ns", m.time_ns},
                            {"direction", m.to_controller ? "to_controller" : "to_host"},
                            {"id", m.id},
                            {"name", m.name},
                            {"counter", m.counter},
                            {"minor", m.minor},
                            {"lost", m.lost},
                            {"repeated", m.repeated},
                            {"malformed", m.malformed},
                            {"tag", m.tag},
                            {"fields", m.fields}});
    }
    return {{"kind", capture.kind},
            {"packets", capture.packets},
            {"messages", std::move(messages)},
            {"to_host", to_json(capture.to_host)},
            {"to_controller", to_json(capture.to_controller)}};
}

std::string text_of(const DecodedCapture& capture) {
    std::string text;
    for (const CapturedMessage& m : capture.messages) {
        std::array<char, 96> head{};
        std::snprintf(head.data(), head.size(), "%6zu %12.6f %s %5u %s", m.packet,
                      static_cast<double>(m.time_ns) * 1e-9, m.to_controller ? "->" : "<-", m.counter,
                      m.name.empty() ? "unknown message" : m.name.c_str());
        text += head.data();
        for (const auto& [name, value] : m.fields.items()) {
            text += " " + name + "=" + (value.is_string() ? value.get<std::string>() : value.dump());
        }
        text += m.tag.empty() ? "" : " seal=" + m.tag;
        text += m.lost > 0 ? " (" + std::to_string(m.lost) + " lost before)" : "";
        text += m.repeated ? " (repeated)" : "";
        text += m.malformed ? " (malformed)" : "";
        text += "\n";
    }
    return text + losses_text("to host", capture.to_host) + losses_text("to controller", capture.to_controller);
}

}  // namespace sc::host
