// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "boards/socketcan/can_socket.hpp"
#include "firmware/hal/io.hpp"

namespace sc::linux_rt {

struct DriveBusCounters {
    std::uint64_t unsent = 0;      ///< frames that found no room or a bus that is down, and were dropped
    std::uint64_t held = 0;        ///< frames that came in a tick beyond what a tick takes; they wait for the next
    std::uint64_t foreign = 0;     ///< extended, remote or FD frames, which no drive sends
    std::uint64_t unanswered = 0;  ///< SYNCs that a drive which had answered before left without an answer
};

/// The drives on one or two CAN buses; a frame of the second carries kSecondDriveBus. Set-points are worth nothing
/// later, so a frame that a bus does not take is dropped and counted. Nothing allocates after the constructor.
class DriveBus {
public:
    explicit DriveBus(std::vector<socketcan::CanSocket> buses);

    /// Frames that have come since the last call, kDriveFramesPerTick at most. Valid until the next call.
    [[nodiscard]] std::span<const DriveFrame> receive() noexcept;
    void send(std::span<const DriveFrame> frames) noexcept;

    /// Whether every drive has answered the SYNCs that it answers (each, or every n-th, as it did before), and every
    /// SDO request to a drive that is there has its reply. Looks at what has come; does not wait.
    [[nodiscard]] bool answered() noexcept;
    /// The wait is over: drives that have not answered are not waited for until they are heard again.
    void give_up() noexcept;
    /// Waits for input on any bus, at most so long (real time).
    void wait(std::int64_t most_ns) noexcept;

    [[nodiscard]] const DriveBusCounters& counters() const noexcept { return counters_; }
    [[nodiscard]] std::span<const socketcan::CanSocket> buses() const noexcept { return buses_; }

private:
    static constexpr std::size_t kNodes = 128;
    static constexpr std::size_t kQueue = 256;

    struct Node {
        bool known = false;       ///< heard since it booted
        bool answer_due = false;  ///< to the last SYNC
        bool reply_due = false;   ///< to an SDO request
        std::uint32_t every = 0;  ///< SYNCs between its answers, as the last two had them; 0: not known
        std::uint32_t since = 0;  ///< SYNCs since its last answer
        bool answered = false;    ///< a SYNC, ever
    };

    void collect() noexcept;
    void note(const DriveFrame& frame) noexcept;
    [[nodiscard]] Node& node_of(const DriveFrame& frame) noexcept;
    void expect(const DriveFrame& frame) noexcept;

    std::vector<socketcan::CanSocket> buses_;
    std::array<std::array<Node, kNodes>, 2> nodes_{};  ///< of each bus
    std::array<DriveFrame, kQueue> queue_{};           ///< heard and not yet handed over
    std::size_t first_ = 0;
    std::size_t size_ = 0;
    std::array<DriveFrame, kDriveFramesPerTick> out_{};
    DriveBusCounters counters_;
};

}  // namespace sc::linux_rt
