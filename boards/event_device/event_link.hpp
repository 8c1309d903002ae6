// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "boards/event_device/event_packets.hpp"

namespace sc::event_device {

struct EventCounters {
    std::uint64_t windows = 0;    ///< sent
    std::uint64_t statuses = 0;   ///< heard
    std::uint64_t malformed = 0;  ///< packets that were no status
    std::uint64_t full = 0;       ///< windows that the device's queue did not take; each is a loss
};

/// The controller's end of an event device. No call but the constructors blocks or allocates. A device that goes, or
/// that does not take a window, is lost for good: this end never opens it again, so that light cannot come back by
/// itself. `send`, `veto` and `receive` may be called from two threads if only one of them sends windows.
class EventLink {
public:
    /// Connects to the device that listens at `path` and tells it of the machine. Throws std::system_error.
    EventLink(const std::string& path, const MachineConfig& machine);
    /// Takes an open socket; closed with this.
    EventLink(int file, const MachineConfig& machine);
    EventLink(const EventLink&) = delete;
    EventLink& operator=(const EventLink&) = delete;
    ~EventLink();

    void send(std::int64_t tick, const ServoOutputs& outputs) noexcept;
    void veto(std::uint8_t causes) noexcept;
    /// The newest status that has come since the last call, its source's bytes those of all of them as far as they fit;
    /// false when none has.
    [[nodiscard]] bool receive(Status& out) noexcept;

    [[nodiscard]] bool lost() const noexcept { return lost_; }
    [[nodiscard]] const EventCounters& counters() const noexcept { return counters_; }
    /// To wait on with poll.
    [[nodiscard]] int file() const noexcept { return file_; }

private:
    [[nodiscard]] bool put(std::size_t size) noexcept;

    int file_;
    bool lost_ = false;
    EventCounters counters_;
    std::array<std::uint8_t, kPacketCapacity> buffer_{};
};

}  // namespace sc::event_device
