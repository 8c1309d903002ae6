// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/canopen.hpp"

#include <bit>

namespace sc::drives::canopen {
namespace {

constexpr std::uint8_t kAbort = 0x80;
constexpr std::uint8_t kDownloadDone = 0x60;

void put(DriveFrame& frame, std::size_t at, std::uint32_t value, std::size_t bytes) noexcept {
    for (std::size_t i = 0; i < bytes; ++i) {
        frame.data[at + i] = static_cast<std::uint8_t>((value >> (8 * i)) & 0xFFU);
    }
}

std::uint32_t get(const DriveFrame& frame, std::size_t at, std::size_t bytes) noexcept {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
        value |= static_cast<std::uint32_t>(frame.data[at + i]) << (8 * i);
    }
    return value;
}

DriveFrame to_node(std::uint16_t base, std::uint16_t address, std::uint8_t size) noexcept {
    DriveFrame frame;
    frame.id = static_cast<std::uint16_t>(base + address);
    frame.size = size;
    return frame;
}

DriveFrame sdo(std::uint8_t node, const ObjectKey& key, std::uint8_t command) noexcept {
    DriveFrame frame = to_node(kSdoRequestBase, node, 8);
    put(frame, 0, command, 1);
    put(frame, 1, key.index, 2);
    put(frame, 3, key.sub, 1);
    return frame;
}

}  // namespace

DriveFrame nmt(NmtCommand command, std::uint8_t node) noexcept {
    DriveFrame frame;
    frame.id = kNmtId;
    frame.size = 2;
    frame.data[0] = static_cast<std::uint8_t>(command);
    frame.data[1] = node;
    return frame;
}

DriveFrame sync() noexcept {
    DriveFrame frame;
    frame.id = kSyncId;
    return frame;
}

DriveFrame heartbeat(std::uint8_t node, NmtState state) noexcept {
    DriveFrame frame = to_node(kHeartbeatBase, node, 1);
    frame.data[0] = static_cast<std::uint8_t>(state);
    return frame;
}

DriveFrame rpdo1(std::uint16_t address, std::uint16_t controlword, std::int32_t target) noexcept {
    DriveFrame frame = to_node(kRpdo1Base, address, 6);
    put(frame, 0, controlword, 2);
    put(frame, 2, std::bit_cast<std::uint32_t>(target), 4);
    return frame;
}

DriveFrame rpdo_pair(std::uint16_t first_address, std::int32_t first, std::int32_t second) noexcept {
    DriveFrame frame = to_node(kRpdo1Base, first_address, 8);
    put(frame, 0, std::bit_cast<std::uint32_t>(first), 4);
    put(frame, 4, std::bit_cast<std::uint32_t>(second), 4);
    return frame;
}

DriveFrame rpdo2(std::uint16_t address, std::uint16_t controlword) noexcept {
    DriveFrame frame = to_node(kRpdo2Base, address, 2);
    put(frame, 0, controlword, 2);
    return frame;
}

DriveFrame sdo_download(std::uint8_t node, const ObjectKey& key, std::uint32_t value) noexcept {
    const std::uint32_t unused = 4U - key.size;
    DriveFrame frame = sdo(node, key, static_cast<std::uint8_t>(0x23U | (unused << 2U)));
    put(frame, 4, value, key.size);
    return frame;
}

DriveFrame sdo_upload(std::uint8_t node, const ObjectKey& key) noexcept { return sdo(node, key, 0x40); }

std::optional<SdoReply> read_sdo_reply(const DriveFrame& frame) noexcept {
    if (frame.size != 8) {
        return std::nullopt;
    }
    const std::uint8_t command = frame.data[0];
    SdoReply reply;
    reply.key.index = static_cast<std::uint16_t>(get(frame, 1, 2));
    reply.key.sub = frame.data[3];
    if (command == kAbort) {
        reply.aborted = true;
        reply.value = get(frame, 4, 4);
        return reply;
    }
    if (command == kDownloadDone) {
        return reply;
    }
    const bool expedited_with_size = (command & 0xF3U) == 0x43U;
    if (!expedited_with_size) {
        return std::nullopt;
    }
    reply.upload = true;
    reply.key.size = static_cast<std::uint8_t>(4U - ((command >> 2U) & 3U));
    reply.value = get(frame, 4, reply.key.size);
    return reply;
}

std::optional<DriveStatus> read_tpdo1(const DriveFrame& frame) noexcept {
    if (frame.size != 6) {
        return std::nullopt;
    }
    return DriveStatus{static_cast<std::uint16_t>(get(frame, 0, 2)), std::bit_cast<std::int32_t>(get(frame, 2, 4))};
}

std::optional<Emergency> read_emergency(const DriveFrame& frame) noexcept {
    if (frame.size != 8) {
        return std::nullopt;
    }
    return Emergency{static_cast<std::uint16_t>(get(frame, 0, 2)), frame.data[2]};
}

}  // namespace sc::drives::canopen
