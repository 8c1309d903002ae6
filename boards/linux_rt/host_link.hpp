// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "boards/port/port.hpp"
#include "boards/socketcan/can_socket.hpp"
#include "firmware/hal/io.hpp"
#include "shared/link/can_carrier.hpp"

namespace sc::linux_rt {

struct LinkCounters {
    std::uint64_t bytes_in = 0;
    std::uint64_t bytes_out = 0;
    std::uint64_t lost = 0;  ///< bytes for the host that nobody took
};

/// Where the host plugs in. Once a tick each way; nothing blocks or allocates after the constructor.
class HostLink {
public:
    HostLink() = default;
    HostLink(const HostLink&) = delete;
    HostLink& operator=(const HostLink&) = delete;
    virtual ~HostLink() = default;

    /// What has come since the last tick, kLinkBytesPerTick at most; what more there is waits.
    [[nodiscard]] virtual std::size_t receive(std::span<std::uint8_t, kLinkBytesPerTick> out) = 0;
    virtual void send(std::span<const std::uint8_t> bytes) = 0;
    /// Where a host finds it, for a person.
    [[nodiscard]] virtual std::string name() const = 0;
    [[nodiscard]] const LinkCounters& counters() const noexcept { return counters_; }
    /// The socket beneath, where there is one.
    [[nodiscard]] virtual const socketcan::CanSocket* can() const noexcept { return nullptr; }

protected:
    LinkCounters counters_;
};

/// A line of bytes: serial, pseudo-terminal or TCP.
class ByteLink final : public HostLink {
public:
    explicit ByteLink(std::unique_ptr<port::Port> port) : port_(std::move(port)) {}
    [[nodiscard]] std::size_t receive(std::span<std::uint8_t, kLinkBytesPerTick> out) override;
    void send(std::span<const std::uint8_t> bytes) override;
    [[nodiscard]] std::string name() const override { return port_->name(); }

private:
    std::unique_ptr<port::Port> port_;
};

/// Messages as frames on a CAN bus (shared/link/can_carrier.hpp).
class CanLink final : public HostLink {
public:
    CanLink(socketcan::CanSocket socket, bool fd, std::string name);
    [[nodiscard]] std::size_t receive(std::span<std::uint8_t, kLinkBytesPerTick> out) override;
    void send(std::span<const std::uint8_t> bytes) override;
    [[nodiscard]] std::string name() const override { return name_; }
    [[nodiscard]] const socketcan::CanSocket* can() const noexcept override { return &socket_; }

private:
    socketcan::CanSocket socket_;
    std::string name_;
    link::CanCarrier<socketcan::CanSocket, 8 * kLinkBytesPerTick> carrier_;
};

/// The open socket that `fd:N` names, as a program that starts this one hands it over; nullopt for another text.
[[nodiscard]] std::optional<int> inherited_file(std::string_view text);
/// Opens the link of `--link`: can:IFACE, can:IFACE?fd=1, serial:DEV, serial:DEV?baud=N, tcp:PORT, tcp:ADDRESS:PORT,
/// or fd:N, a socket with CAN frames.
/// Throws std::invalid_argument for another text, std::system_error when it cannot be opened.
[[nodiscard]] std::unique_ptr<HostLink> open_host_link(const std::string& text);

}  // namespace sc::linux_rt
