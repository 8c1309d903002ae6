// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace sc::host {

/// What the kernel says of a CAN interface (rtnetlink, linux/can/netlink.h). A virtual one has no rates.
struct CanDetails {
    std::string kind;  ///< can, vcan, vxcan
    std::optional<std::uint32_t> bitrate;
    std::optional<std::uint32_t> data_bitrate;
    std::string state;               ///< error-active, error-warning, error-passive, bus-off, stopped, sleeping
    std::uint32_t restart_ms = 0;    ///< 0: bus-off stays until somebody restarts it
    std::uint32_t queue_length = 0;  ///< txqueuelen
};

/// Reads one answer to RTM_GETLINK; nullopt when it is none, or not whole.
[[nodiscard]] std::optional<CanDetails> parse_can_link(std::span<const std::uint8_t> message);
/// Asks the kernel of an interface by its number. nullopt when it does not answer. Never throws.
[[nodiscard]] std::optional<CanDetails> ask_can_link(unsigned index);

}  // namespace sc::host
