// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/hal/io.hpp"
#include "shared/codes/codes.hpp"
#include "shared/machine/machine.hpp"

/// CiA 402 master for the four axes, in cyclic synchronous position mode over CANopen: NMT, set-up by expedited SDO,
/// PDOs on SYNC, heartbeat and EMCY consumer, one transition per confirmed statusword, homing. See docs/drives.md.

namespace sc::drives {

/// What the controller wants of all drives this tick.
struct Request {
    bool power = false;          ///< bring to / keep in Operation enabled; false: take down to Switch on disabled
    bool home = false;           ///< run the homing of the axes in `home_axes`; held until `homing_done` or a fault
    std::uint8_t home_axes = 0;  ///< bits by Axis
    bool reset = false;          ///< fault reset edge for drives in fault
    bool quick_stop = false;     ///< on a fault: stop by the drives' own ramp
    AxisPositions target{};      ///< pm / ndeg; used in Operation enabled, rounded to counts here and nowhere else
};

struct AxisStatus {
    bool present = false;  ///< heartbeat and PDOs arrive in time
    bool enabled = false;  ///< Operation enabled, confirmed
    bool homed = false;
    bool fault = false;  ///< in Fault or Fault reaction active
    bool homing_failed = false;
    std::uint16_t error_code = 0;  ///< last EMCY
    std::int64_t actual = 0;       ///< pm / ndeg, from the last TPDO
    std::uint16_t statusword = 0;
};

struct Outcome {
    std::array<AxisStatus, kAxisCount> axis{};
    bool all_present = false;
    bool all_enabled = false;
    bool all_disabled = false;
    bool homing_done = false;   ///< every requested axis is homed and back in CSP
    bool actual_fresh = false;  ///< TPDOs of all present axes arrived since the last SYNC
};

/// Non-blocking; one object for the controller's life. No heap. Bounded: O(axes + received frames) per tick.
class DriveMaster {
public:
    explicit DriveMaster(const MachineConfig& machine) noexcept;

    /// Control tick. `out` receives frames to send (appended to `out_size`); SYNC goes out every `drive_cycle_ticks`,
    /// targets just before it. When a drive is enabled, its target is first preset to its actual position: the caller
    /// reads `Outcome::axis[].actual` and must start its set-points there.
    Outcome step(std::int64_t tick, std::span<const DriveFrame> received, const Request& request,
                 ServoOutputs& out) noexcept;

private:
    // (to be filled in)
    const MachineConfig* machine_;
};

}  // namespace sc::drives
