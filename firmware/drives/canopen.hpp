// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "firmware/hal/io.hpp"

/// CANopen (CiA 301) frames that the master sends and reads: identifiers of the predefined connection set, NMT, SYNC,
/// heartbeat, expedited SDO and the two PDOs of a drive. Little-endian on the wire. Pure functions, any context.

namespace sc::drives::canopen {

inline constexpr std::uint16_t kNmtId = 0x000;
inline constexpr std::uint16_t kSyncId = 0x080;
inline constexpr std::uint16_t kEmcyBase = 0x080;
inline constexpr std::uint16_t kTpdo1Base = 0x180;
inline constexpr std::uint16_t kRpdo1Base = 0x200;
inline constexpr std::uint16_t kRpdo2Base = 0x300;
inline constexpr std::uint16_t kSdoReplyBase = 0x580;
inline constexpr std::uint16_t kSdoRequestBase = 0x600;
inline constexpr std::uint16_t kHeartbeatBase = 0x700;
inline constexpr std::uint16_t kNodeMask = 0x07F;
/// Node id of this master, as the drives' heartbeat consumers know it.
inline constexpr std::uint8_t kMasterNode = 127;

enum class NmtCommand : std::uint8_t { start = 0x01, stop = 0x02, pre_operational = 0x80, reset_node = 0x81 };
enum class NmtState : std::uint8_t { boot_up = 0x00, stopped = 0x04, operational = 0x05, pre_operational = 0x7F };

/// An object's address and the number of its bytes, 1, 2 or 4.
struct ObjectKey {
    std::uint16_t index = 0;
    std::uint8_t sub = 0;
    std::uint8_t size = 0;
    constexpr bool operator==(const ObjectKey&) const noexcept = default;
};

/// A server's answer to an expedited request.
struct SdoReply {
    ObjectKey key{};  ///< size is 0 for a confirmed download and for an abort
    bool aborted = false;
    bool upload = false;
    std::uint32_t value = 0;  ///< the data, zero-extended, or the abort code
};

/// RPDO1: 6040 + 607A. TPDO1: 6041 + 6064.
struct DriveStatus {
    std::uint16_t statusword = 0;
    std::int32_t actual = 0;  ///< counts
};
struct Emergency {
    std::uint16_t error_code = 0;
    std::uint8_t error_register = 0;
};

[[nodiscard]] DriveFrame nmt(NmtCommand command, std::uint8_t node) noexcept;
[[nodiscard]] DriveFrame sync() noexcept;
[[nodiscard]] DriveFrame heartbeat(std::uint8_t node, NmtState state) noexcept;
/// Of the RPDOs: `address` is the node, with kSecondDriveBus for one of the second bus.
[[nodiscard]] DriveFrame rpdo1(std::uint16_t address, std::uint16_t controlword, std::int32_t target) noexcept;
/// RPDO1 of a pair, under the identifier of its first drive: both targets. RPDO2 of each of the two: 6040.
[[nodiscard]] DriveFrame rpdo_pair(std::uint16_t first_address, std::int32_t first, std::int32_t second) noexcept;
[[nodiscard]] DriveFrame rpdo2(std::uint16_t address, std::uint16_t controlword) noexcept;
[[nodiscard]] DriveFrame sdo_download(std::uint8_t node, const ObjectKey& key, std::uint32_t value) noexcept;
[[nodiscard]] DriveFrame sdo_upload(std::uint8_t node, const ObjectKey& key) noexcept;

/// Empty for a frame of the wrong length or with a command that is no answer to an expedited request.
[[nodiscard]] std::optional<SdoReply> read_sdo_reply(const DriveFrame& frame) noexcept;
[[nodiscard]] std::optional<DriveStatus> read_tpdo1(const DriveFrame& frame) noexcept;
[[nodiscard]] std::optional<Emergency> read_emergency(const DriveFrame& frame) noexcept;

}  // namespace sc::drives::canopen
