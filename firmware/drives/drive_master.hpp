// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <span>

#include "firmware/drives/drive_node.hpp"
#include "firmware/hal/io.hpp"
#include "shared/codes/codes.hpp"
#include "shared/drives/bus_budget.hpp"
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
    /// `target` is used from the next tick on. While false (not all drives enabled yet, homing, coming back from it)
    /// the drive holds its place and the caller must keep its set-point at `actual`.
    bool follows = false;
    bool homed = false;
    bool fault = false;  ///< in Fault or Fault reaction active
    bool homing_failed = false;
    std::uint16_t error_code = 0;  ///< last EMCY, until the next reset
    std::int64_t actual = 0;       ///< pm / ndeg, from the last TPDO
    std::uint16_t statusword = 0;
};

struct Outcome {
    std::array<AxisStatus, kAxisCount> axis{};
    bool all_present = false;
    bool all_enabled = false;
    bool all_follow = false;
    bool all_disabled = false;  ///< no present drive has power on its motor
    bool homing_done = false;   ///< every requested axis is homed and back in CSP
    /// At the last SYNC tick, every present drive had answered the SYNC before it. False is the first sign of a lost
    /// drive, long before `present` falls.
    bool actual_fresh = false;
};

/// Finds the ticks that are multiples of a number, without a division while they come one after the other.
class Period {
public:
    /// In ticks; less than 1 means 1.
    constexpr explicit Period(std::int64_t count) noexcept : count_(count > 0 ? count : 1) {}
    [[nodiscard]] constexpr std::int64_t count() const noexcept { return count_; }
    /// `tick` is a multiple. Any order of ticks is right, one by one is fast.
    [[nodiscard]] constexpr bool begins(std::int64_t tick) noexcept {
        const std::int64_t since = tick - begin_;
        if (since < 0 || since > count_) {
            begin_ = tick - tick % count_;
        } else if (since == count_) {
            begin_ = tick;
        }
        return begin_ == tick;
    }

private:
    std::int64_t count_;
    std::int64_t begin_ = 0;  ///< a multiple
};

/// Non-blocking; one object for the controller's life. No heap. Bounded: O(axes + received frames) per tick, at most
/// 14 frames out of kDriveFramesPerTick.
class DriveMaster {
public:
    explicit DriveMaster(const MachineConfig& machine, const DrivePlan& plan = kPlainDrives) noexcept;

    /// Uses the drive's SDO channel while the master does not. Outlives the master; null: nobody.
    void attach(std::size_t axis, SdoService* service) noexcept {
        nodes_[axis < kAxisCount ? axis : 0].attach(service);
    }

    /// Share of the bus at worst, or why the configuration is refused; a refused master sends nothing and finds no
    /// drive present.
    [[nodiscard]] const std::expected<BusBudget, Refusal>& budget() const noexcept { return budget_; }

    /// Where the drives stood at a SYNC, by the answers to it among the frames of this tick: pm / ndeg, and in `t_tick`
    /// the tick at whose beginning that was. False without an answer of each drive. A look ahead of `step`, which takes
    /// the same frames.
    [[nodiscard]] bool measured(std::int64_t tick, std::span<const DriveFrame> received, AxisPositions& place,
                                std::int64_t& t_tick) const noexcept;

    /// Bits by Axis: drives of which a frame of this tick tells a fault (status word or EMCY). A look ahead of `step`,
    /// whose outcome is used a tick later; of drives that are not present it says nothing.
    [[nodiscard]] std::uint8_t faults_told(std::span<const DriveFrame> received) const noexcept;

    /// Control tick. `out` receives frames to send (appended to `drive_tx_size`); SYNC goes out every
    /// `drive_cycle_ticks`, targets just before it. When a drive is enabled, its target is first preset to its actual
    /// position: the caller reads `Outcome::axis[].actual` and must start its set-points there when `follows` comes.
    /// `reset` may be a single tick; the drive leaves Fault some cycles later or stays in it. Homing that is withdrawn
    /// is broken off by the drive's ramp; `follows` returns when the drive is back in CSP.
    Outcome step(std::int64_t tick, std::span<const DriveFrame> received, const Request& request,
                 ServoOutputs& out) noexcept;

private:
    Outcome run(std::int64_t tick, std::span<const DriveFrame> received, const Request& request,
                ServoOutputs& out) noexcept;
    [[nodiscard]] NodeRequest node_request(std::size_t axis, const Request& request) const noexcept;
    void receive(std::span<const DriveFrame> received, std::int64_t tick) noexcept;
    void send_cycle(ServoOutputs& out) noexcept;
    void append_on_buses(ServoOutputs& out, const DriveFrame& frame) const noexcept;
    void send_targets(ServoOutputs& out) noexcept;
    void send_controlword(std::uint16_t bus_bit, ServoOutputs& out) noexcept;
    void send_other(std::int64_t tick, bool cycle, ServoOutputs& out) noexcept;
    [[nodiscard]] Outcome outcome(const Request& request) const noexcept;
    [[nodiscard]] AxisStatus status(const DriveNode& node) const noexcept;

    std::expected<BusBudget, Refusal> budget_;
    std::array<DriveNode, kAxisCount> nodes_;
    std::array<TargetPair, kAxisCount> pairs_{};
    std::uint8_t buses_ = 0;  ///< bits: those that have a drive
    bool any_paired_ = false;
    Period cycle_ticks_{1};
    Period heartbeat_ticks_{1};
    bool all_enabled_ = false;
    bool fresh_ = false;
};

}  // namespace sc::drives
