// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <variant>

namespace sc::host {

/// What the link of a simulated cell runs over.
enum class SimCarrier : std::uint8_t { serial, can, canfd };

struct SimulatedUrl {
    SimCarrier carrier = SimCarrier::serial;
};
struct LockStepUrl {
    std::string path;  ///< of the cell's socket
    SimCarrier carrier = SimCarrier::serial;
};
struct SerialUrl {
    std::string device;
    unsigned baud = 0;  ///< 0: as the device stands
};
struct TcpUrl {
    std::string host;
    std::uint16_t port = 0;
};
struct CanUrl {
    std::string interface;
    bool fd = false;
};
using LinkUrl = std::variant<SimulatedUrl, LockStepUrl, SerialUrl, TcpUrl, CanUrl>;

/// Takes a link's URL apart (open_transport.hpp lists them). Opens nothing. Throws InputError for an unknown scheme, a
/// missing device or interface, and a port or a speed that is none.
[[nodiscard]] LinkUrl parse_link_url(const std::string& url);

}  // namespace sc::host
