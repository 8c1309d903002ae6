// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "host/bridge/transport.hpp"
#include "host/bridge/unique_fd.hpp"

namespace sc::host {

/// What a bus has done to a link.
struct CanBusCounters {
    std::uint64_t full = 0;      ///< frames that found no room in the interface's queue; they waited
    std::uint64_t down = 0;      ///< sends and reads that found the interface down
    std::uint64_t bus_offs = 0;  ///< error frames
    std::uint64_t restarts = 0;
    std::uint64_t errors = 0;     ///< error frames, of any kind
    std::uint64_t malformed = 0;  ///< packets that were no frame
};

/// A raw CAN socket as a carrier of records (shared/link/can_record.hpp), for CanTransport, on the real, monotonic
/// clock. Frames that the interface has no room for wait, in order; while it is down they are dropped, as a bus that is
/// cut drops them, and the link goes on by itself when it is up again. Only an interface that is gone closes it.
class SocketCanTransport final : public Transport {
public:
    /// Takes a raw CAN socket, or one of a socket pair that carries the same structures.
    SocketCanTransport(UniqueFd socket, bool fd);

    void send(std::span<const std::uint8_t> records) override;
    std::size_t receive(std::span<std::uint8_t> out, HostTime until) override;
    [[nodiscard]] HostTime now() const override;
    [[nodiscard]] bool closed() const override { return closed_; }
    [[nodiscard]] const CanBusCounters& counters() const noexcept { return counters_; }

private:
    void flush();
    [[nodiscard]] bool take_one(std::vector<std::uint8_t>& record);
    void note_trouble(int error);

    UniqueFd socket_;
    bool fd_;
    bool closed_ = false;
    std::deque<std::vector<std::uint8_t>> waiting_;
    std::vector<std::uint8_t> begun_;  ///< of a record that has not come whole
    CanBusCounters counters_;
};

/// Opens an interface for the link's frames. Throws InputError when the kernel has no SocketCAN, when there is no such
/// interface, or when FD is asked of one that carries classic frames only.
[[nodiscard]] std::unique_ptr<Transport> open_socket_can(const std::string& interface, bool fd);

}  // namespace sc::host
