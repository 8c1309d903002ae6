// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace sc::port {

/// Where a host plugs in to a controller that runs in real time: a line of bytes. One client after another. Only the
/// functions that open one block or allocate.
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
    /// What the client has sent, as much as fits; how many bytes. Notices clients that come and go.
    [[nodiscard]] virtual std::size_t receive(std::span<std::uint8_t> out) = 0;
    /// Sends to the client; how many bytes were taken. The rest is lost: there is no client, or it does not read.
    virtual std::size_t send(std::span<const std::uint8_t> bytes) = 0;
};

/// A serial line or pseudo-terminal that is there, raw, 8N1, no flow control. `baud` 0: the speed stays as it is.
/// Throws std::system_error when it cannot be opened, std::invalid_argument when it is none or the speed is not one of
/// the kernel's.
[[nodiscard]] std::unique_ptr<Port> open_serial(const std::string& device, unsigned baud);
/// A new pseudo-terminal in raw mode. Throws std::system_error.
[[nodiscard]] std::unique_ptr<Port> open_pty();
/// A listening TCP socket on `address` (IPv4), port 0 = any free one. Throws std::system_error, std::invalid_argument
/// for an address that is none.
[[nodiscard]] std::unique_ptr<Port> open_tcp(std::uint16_t port, const std::string& address = "127.0.0.1");

}  // namespace sc::port
