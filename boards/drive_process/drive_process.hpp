// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "boards/sim/plant/drive.hpp"
#include "boards/socketcan/can_socket.hpp"

namespace sc::drive_process {

struct Counters {
    std::uint64_t syncs = 0;
    std::uint64_t received = 0;
    std::uint64_t sent = 0;
    std::uint64_t lost = 0;  ///< the bus took them not even after a while
};

/// Simulated drives on one CAN bus. A SYNC is one drive cycle of their time; between two SYNCs they only answer.
class DriveProcess {
public:
    DriveProcess(socketcan::CanSocket socket, const std::vector<sim::SimDriveOptions>& drives, std::int64_t cycle_ns);

    /// Works until `stop` is set, or the peer of a socket pair has gone. Waits at most 100 ms at a time.
    void run(const std::atomic<bool>& stop);

    [[nodiscard]] const Counters& counters() const { return counters_; }
    [[nodiscard]] const std::vector<sim::SimDrive>& drives() const { return drives_; }

private:
    void take(const socketcan::CanFrame& frame);
    void answer();

    socketcan::CanSocket socket_;
    std::vector<sim::SimDrive> drives_;
    std::vector<DriveFrame> out_;
    std::int64_t cycle_ns_;
    std::int64_t t_ns_ = 0;
    Counters counters_;
};

}  // namespace sc::drive_process
