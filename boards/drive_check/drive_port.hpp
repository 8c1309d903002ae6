// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "boards/socketcan/can_socket.hpp"

namespace sc::drive_check {

/// A classic frame with 11-bit identifier.
struct Frame {
    std::uint32_t id = 0;
    std::vector<std::uint8_t> data;
};

/// What a drive hangs on.
class DrivePort {
public:
    virtual ~DrivePort() = default;
    virtual void send(const Frame& frame) = 0;
    /// Lets one drive cycle pass, with a SYNC at its beginning; what the drive has sent until its end.
    virtual std::vector<Frame> cycle() = 0;
    /// Waits for what the drive answers without time passing for it (SDO). Empty: nothing.
    virtual std::vector<Frame> answers() = 0;
    [[nodiscard]] virtual double cycle_ms() const = 0;
};

/// On a CAN bus. A simulated drive takes its time from the SYNCs, so none of it counts here but how long to wait for an
/// answer. `real_time`: a real drive, whose SYNCs come at the cycle.
class CanPort final : public DrivePort {
public:
    CanPort(socketcan::CanSocket socket, double cycle_ms, bool real_time, int patience_ms);
    void send(const Frame& frame) override;
    std::vector<Frame> cycle() override;
    std::vector<Frame> answers() override;
    [[nodiscard]] double cycle_ms() const override { return cycle_ms_; }
    /// The node whose SDO answer shows that a cycle has been worked off.
    void fence(std::uint8_t node) { node_ = node; }

private:
    void gather(std::vector<Frame>& out, int wait_ms, std::uint32_t until_id, bool fenced);

    socketcan::CanSocket socket_;
    double cycle_ms_;
    bool real_time_;
    int patience_ms_;
    std::uint8_t node_ = 0;
    bool silent_ = false;  ///< the last fence stayed unanswered
    int late_fences_ = 0;  ///< their answers may still come
    std::int64_t next_ns_ = 0;
};

}  // namespace sc::drive_check
