// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "boards/stm32h743/link/fdcan.hpp"
#include "firmware/hal/io.hpp"

namespace sc::stm32h743 {

struct DrivePortCounters {
    std::uint32_t unsent = 0;   ///< frames that found no room or a bus that is down, and were dropped
    std::uint32_t foreign = 0;  ///< extended, remote or FD frames, which no drive sends
};

/// The drives on one or two FDCANs; a frame of the second carries kSecondDriveBus. Set-points are worth nothing later,
/// so a frame that a bus does not take is dropped and counted. Tick context.
class DrivePorts {
public:
    /// `second` may be null.
    DrivePorts(Fdcan& first, Fdcan* second) noexcept : ports_{&first, second} {}

    /// Frames that have come since the last call, kDriveFramesPerTick at most; more wait. Valid until the next call.
    [[nodiscard]] std::span<const DriveFrame> receive() noexcept;
    void send(std::span<const DriveFrame> frames) noexcept;
    /// Once a tick.
    void service(std::int64_t now_ns) noexcept;
    [[nodiscard]] const DrivePortCounters& counters() const noexcept { return counters_; }

private:
    std::array<Fdcan*, 2> ports_;
    std::array<DriveFrame, kDriveFramesPerTick> heard_{};
    DrivePortCounters counters_;
};

}  // namespace sc::stm32h743
