// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sc::sim {

enum class LinkCarrier : std::uint8_t {
    serial,  ///< bytes, ten bits each
    can,     ///< classic CAN, 1 Mbit/s; the host gives and takes frames as records (shared/link/can_record.hpp)
    canfd,   ///< CAN FD, 1 and 5 Mbit/s; likewise
};

/// What lies between a host and the controller's link, in virtual time, tick by tick. The controller speaks the same
/// bytes whatever the carrier.
class LinkLine {
public:
    LinkLine() = default;
    LinkLine(const LinkLine&) = delete;
    LinkLine& operator=(const LinkLine&) = delete;
    virtual ~LinkLine() = default;

    /// From the host, at the start of a tick.
    virtual void push_host(std::span<const std::uint8_t> bytes) = 0;
    /// From the controller, for the tick that has begun.
    virtual void push_controller(std::span<const std::uint8_t> bytes) = 0;
    /// The tick is over: appends what has come through to either end.
    virtual void tick(std::vector<std::uint8_t>& to_controller, std::vector<std::uint8_t>& to_host) = 0;
    /// Cuts or joins the line. While it is cut all is lost, what is on its way too.
    virtual void set_connected(bool connected) = 0;
};

/// `baud` is of a serial line.
[[nodiscard]] std::unique_ptr<LinkLine> make_link_line(LinkCarrier carrier, std::uint32_t baud, std::int64_t tick_ns);

}  // namespace sc::sim
