// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "firmware/drives/drive_configuration.hpp"
#include "firmware/drives/homing_sequence.hpp"
#include "firmware/drives/sdo_client.hpp"
#include "firmware/drives/sdo_service.hpp"

namespace sc::drives {

/// What one drive is asked for in this tick.
struct NodeRequest {
    bool power = false;
    bool home = false;
    bool reset = false;
    bool quick_stop = false;
    bool may_follow = false;  ///< all drives are enabled: the target may be used
    std::int64_t target = 0;  ///< pm / ndeg
};

/// One drive as the master keeps it: boot, set-up, state machine, homing, liveness. Time is counted in control ticks.
class DriveNode {
public:
    DriveNode() noexcept = default;
    DriveNode(const MachineConfig& machine, std::size_t axis, const DrivePlan& plan = kPlainDrives) noexcept;

    /// Identifiers of its frames are a base plus this: the node, and the bit of its bus.
    [[nodiscard]] std::uint16_t address() const noexcept { return address_; }
    [[nodiscard]] std::uint16_t bus_bit() const noexcept { return address_ & kSecondDriveBus; }
    /// A frame that this node has sent, and not another one.
    [[nodiscard]] bool sent(const DriveFrame& frame) const noexcept {
        return (frame.id & (canopen::kNodeMask | kSecondDriveBus)) == address_;
    }
    [[nodiscard]] bool paired() const noexcept { return paired_; }
    /// Uses the SDO channel while this node does not. Outlives the node; null: nobody.
    void attach(SdoService* service) noexcept { service_ = service; }

    /// A frame of this node.
    void receive(const DriveFrame& frame, std::int64_t tick) noexcept;
    /// Once a tick after the frames; `cycle`: an RPDO follows in this tick.
    void update(const NodeRequest& request, std::int64_t tick, bool cycle) noexcept;

    /// False: `nmt_frame` is empty.
    [[nodiscard]] bool nmt_due() const noexcept { return nmt_due_; }
    /// `cycle`: number of the last drive cycle. Where the status comes with every n-th SYNC only, the start waits for
    /// this node's turn among them, so that not all answer the same SYNC.
    [[nodiscard]] std::optional<DriveFrame> nmt_frame(std::int64_t cycle) noexcept;
    [[nodiscard]] std::optional<DriveFrame> sdo_frame(std::int64_t tick) noexcept;
    /// Empty until the node is operational, and for one that is paired. Call in a `cycle` tick after `update`.
    [[nodiscard]] std::optional<DriveFrame> rpdo_frame() const noexcept;
    /// Of a paired node: the controlword has changed, or has not been sent for a while.
    [[nodiscard]] bool controlword_due() const noexcept;
    [[nodiscard]] bool urgent() const noexcept { return controlword_ == axis402::kQuickStop; }
    [[nodiscard]] DriveFrame controlword_frame() noexcept;
    [[nodiscard]] std::int32_t target_counts() const noexcept { return target_counts_; }

    /// Once a drive cycle: a status has arrived within the last `status_every` of them.
    [[nodiscard]] bool take_fresh() noexcept;

    [[nodiscard]] bool present() const noexcept { return phase_ == Phase::operational; }
    [[nodiscard]] axis402::PowerState power_state() const noexcept { return power_; }
    [[nodiscard]] bool enabled() const noexcept {
        const bool in_operation = phase_ == Phase::operational && power_ == axis402::PowerState::operation_enabled;
        return in_operation && (homing_.active() || (statusword_ & axis402::kBit12) != 0);
    }
    [[nodiscard]] bool follows() const noexcept { return following_; }
    [[nodiscard]] bool fault() const noexcept;
    [[nodiscard]] const HomingSequence& homing() const noexcept { return homing_; }
    [[nodiscard]] std::uint16_t statusword() const noexcept { return statusword_; }
    [[nodiscard]] std::uint16_t error_code() const noexcept { return error_code_; }
    /// pm / ndeg
    [[nodiscard]] std::int64_t actual() const noexcept;
    /// The place in an answer of this node to a SYNC, pm / ndeg; of any other frame none.
    [[nodiscard]] std::optional<std::int64_t> measured(const DriveFrame& frame) const noexcept;
    /// This frame of any node tells that this one is in a fault: a statusword that says so, or an EMCY with a code.
    [[nodiscard]] bool tells_fault(const DriveFrame& frame) const noexcept;

private:
    /// resetting: reset is sent, the boot-up message is awaited. setup: SDOs. starting: NMT start is sent, the first
    /// status is awaited. pausing: something failed, reset again after a while.
    enum class Phase : std::uint8_t { resetting, setup, starting, operational, pausing };

    void enter(Phase phase, std::int64_t tick) noexcept;
    void boot_up(std::int64_t tick) noexcept;
    void run_setup(std::int64_t tick) noexcept;
    void begin_step() noexcept;
    [[nodiscard]] bool step_done(bool& failed) noexcept;
    void watch_liveness(std::int64_t tick) noexcept;
    void operate(const NodeRequest& request, std::int64_t tick, bool cycle) noexcept;
    [[nodiscard]] std::uint8_t node() const noexcept {
        return static_cast<std::uint8_t>(address_ & canopen::kNodeMask);
    }
    [[nodiscard]] DriveFrame on_bus(DriveFrame frame) const noexcept;
    void run_brake(const NodeRequest& request, std::int64_t tick) noexcept;
    [[nodiscard]] std::uint16_t command(const NodeRequest& request) noexcept;
    [[nodiscard]] std::uint16_t fault_command() noexcept;
    void choose_target(const NodeRequest& request, bool follow) noexcept;

    /// Of an axis that would fall. closing: it was told to close, the motor still holds. opening: it was told to open,
    /// the target waits.
    enum class Brake : std::uint8_t { closed, opening, open, closing };

    DriveSetup setup_{};
    SdoService* service_ = nullptr;
    SdoClient sdo_{};
    HomingSequence homing_{};
    double units_per_count_ = 1.0;
    std::int64_t heartbeat_ticks_ = 100;
    std::int64_t status_ticks_ = 10;
    std::int64_t phase_tick_ = 0;
    std::int64_t heard_tick_ = 0;
    std::int64_t status_tick_ = 0;
    std::int32_t actual_counts_ = 0;
    std::int32_t target_counts_ = 0;
    std::int64_t brake_tick_ = 0;
    std::size_t step_ = 0;
    std::uint16_t address_ = 0;
    std::uint16_t release_ticks_ = 0;
    std::uint16_t apply_ticks_ = 0;
    std::uint16_t sent_controlword_ = 0;
    std::uint8_t unsent_cycles_ = 0;
    std::uint8_t status_every_ = 1;
    std::uint8_t turn_ = 0;
    std::uint8_t stale_cycles_ = 0;
    std::uint16_t statusword_ = 0;
    std::uint16_t error_code_ = 0;
    std::uint16_t controlword_ = 0;
    std::uint8_t reset_cycles_ = 0;
    Phase phase_ = Phase::resetting;
    axis402::PowerState power_ = axis402::PowerState::unknown;
    Brake brake_ = Brake::closed;
    bool paired_ = false;
    bool nmt_due_ = true;
    bool step_begun_ = false;
    bool reading_back_ = false;
    bool fresh_ = false;
    bool new_status_ = false;
    bool following_ = false;
};

}  // namespace sc::drives
