// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace sc::sim {

/// Where a host plugs in to a cell that runs in real time. One client after another; never blocks.
class Port {
public:
    Port() = default;
    Port(const Port&) = delete;
    Port& operator=(const Port&) = delete;
    virtual ~Port() = default;

    /// What to tell the person: the pseudo-terminal's path or the TCP port.
    [[nodiscard]] virtual std::string name() const = 0;
    /// File to wait on for input, −1 when there is none to wait on.
    [[nodiscard]] virtual int file() const = 0;
    /// Appends what the client has sent. Notices clients that come and go.
    virtual void receive(std::vector<std::uint8_t>& out) = 0;
    /// Sends to the client. Bytes are lost when there is none or when it does not read.
    virtual void send(std::span<const std::uint8_t> bytes) = 0;
};

/// A pseudo-terminal in raw mode. Throws std::system_error.
[[nodiscard]] std::unique_ptr<Port> open_pty();
/// A listening TCP socket on 127.0.0.1, port 0 = any free one. Throws std::system_error.
[[nodiscard]] std::unique_ptr<Port> open_tcp(std::uint16_t port);

}  // namespace sc::sim
