// SPDX-License-Identifier: Apache-2.0
#include "boards/event_device/event_packets.hpp"

#include <algorithm>

#include "shared/wire/bytes.hpp"

namespace sc::event_device {
namespace {

void put_kind(ByteWriter& out, Packet kind) noexcept { out.put(static_cast<std::uint8_t>(kind)); }

bool is(std::span<const std::uint8_t> bytes, Packet kind) noexcept {
    return !bytes.empty() && bytes[0] == static_cast<std::uint8_t>(kind);
}

}  // namespace

std::size_t put_begin(const MachineConfig& machine, std::span<std::uint8_t> out) noexcept {
    std::array<std::uint8_t, link::kConfigSize> config{};
    link::serialise(machine, config);
    ByteWriter writer(out);
    put_kind(writer, Packet::begin);
    writer.put(kVersion);
    writer.put_bytes(config);
    return writer.size();
}

std::size_t put_window(std::int64_t tick, const ServoOutputs& outputs, std::span<std::uint8_t> out) noexcept {
    ByteWriter writer(out);
    put_kind(writer, Packet::window);
    writer.put(tick);
    const std::size_t size = recording::pack(outputs, out.subspan(kWindowHead));
    return size == 0 ? 0 : kWindowHead + size;
}

std::size_t put_veto(std::uint8_t causes, std::span<std::uint8_t> out) noexcept {
    ByteWriter writer(out);
    put_kind(writer, Packet::veto);
    writer.put(causes);
    return writer.size();
}

std::size_t put_status(const Status& status, std::span<std::uint8_t> out) noexcept {
    ByteWriter writer(out);
    put_kind(writer, Packet::status);
    writer.put(status.tick);
    writer.put(recording::bits_of(status.lines));
    writer.put(static_cast<std::uint8_t>(status.source_size));
    writer.put_bytes(std::span(status.source).first(status.source_size));
    return writer.size();
}

std::optional<Packet> kind_of(std::span<const std::uint8_t> bytes) noexcept {
    for (const Packet kind : {Packet::begin, Packet::window, Packet::veto, Packet::status}) {
        if (is(bytes, kind)) {
            return kind;
        }
    }
    return std::nullopt;
}

bool get_begin(std::span<const std::uint8_t> bytes, MachineConfig& machine) noexcept {
    if (!is(bytes, Packet::begin) || bytes.size() != kBeginSize) {
        return false;
    }
    ByteReader reader(bytes.subspan(1));
    return reader.get<std::uint16_t>() == kVersion &&
           link::deserialise_into(machine, bytes.subspan(3)) == Refusal::none;
}

bool get_window(std::span<const std::uint8_t> bytes, std::int64_t& tick, ServoOutputs& outputs) noexcept {
    if (!is(bytes, Packet::window) || bytes.size() <= kWindowHead) {
        return false;
    }
    ByteReader reader(bytes.subspan(1));
    tick = reader.get<std::int64_t>();
    return recording::unpack(bytes.subspan(kWindowHead), outputs);
}

bool get_veto(std::span<const std::uint8_t> bytes, std::uint8_t& causes) noexcept {
    causes = is(bytes, Packet::veto) && bytes.size() == 2 ? bytes[1] : std::uint8_t{0};
    return is(bytes, Packet::veto) && bytes.size() == 2;
}

bool get_status(std::span<const std::uint8_t> bytes, Status& status) noexcept {
    constexpr std::size_t kHead = 1 + 8 + 2 + 1;
    if (!is(bytes, Packet::status) || bytes.size() < kHead || bytes.size() > kStatusCapacity) {
        return false;
    }
    ByteReader reader(bytes.subspan(1));
    status.tick = reader.get<std::int64_t>();
    status.lines = recording::digital_inputs(reader.get<std::uint16_t>());
    status.source_size = reader.get<std::uint8_t>();
    if (status.source_size > status.source.size() || bytes.size() != kHead + status.source_size) {
        return false;
    }
    std::copy(bytes.begin() + kHead, bytes.end(), status.source.begin());
    return true;
}

}  // namespace sc::event_device
