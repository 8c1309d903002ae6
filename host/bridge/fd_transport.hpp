// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host/bridge/transport.hpp"
#include "host/bridge/unique_fd.hpp"

namespace sc::host {

/// Bytes over a descriptor (serial line, pseudo-terminal, socket) on the real, monotonic clock.
class FdTransport final : public Transport {
public:
    /// Takes the descriptor and makes it non-blocking.
    explicit FdTransport(UniqueFd fd);

    void send(std::span<const std::uint8_t> bytes) override;
    std::size_t receive(std::span<std::uint8_t> out, HostTime until) override;
    [[nodiscard]] HostTime now() const override;
    [[nodiscard]] bool closed() const override { return closed_; }

private:
    void flush();

    UniqueFd fd_;
    std::vector<std::uint8_t> waiting_;  ///< bytes that the descriptor has not taken yet
    bool closed_ = false;
};

/// Opens a serial line or pseudo-terminal raw, 8N1, no flow control. `baud` 0 leaves the speed as it is. Throws
/// InputError when the device is missing, is none, or the speed is not one that the kernel knows.
[[nodiscard]] std::unique_ptr<Transport> open_serial(const std::filesystem::path& device, unsigned baud);
/// Connects to `host:port` (no delay, keep-alive off: the heartbeat does that). Throws LinkError when nobody answers.
[[nodiscard]] std::unique_ptr<Transport> open_tcp(const std::string& host, std::uint16_t port);

}  // namespace sc::host
