// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/drive_master.hpp"

namespace sc::drives {
namespace {

void append(ServoOutputs& out, const DriveFrame& frame) noexcept {
    if (out.drive_tx_size < out.drive_tx.size()) {
        out.drive_tx[out.drive_tx_size++] = frame;
    }
}

void append(ServoOutputs& out, const std::optional<DriveFrame>& frame) noexcept {
    if (frame) {
        append(out, *frame);
    }
}

bool unpowered(axis402::PowerState state) noexcept {
    switch (state) {
        case axis402::PowerState::not_ready:
        case axis402::PowerState::switch_on_disabled:
        case axis402::PowerState::fault: return true;
        case axis402::PowerState::ready_to_switch_on:
        case axis402::PowerState::switched_on:
        case axis402::PowerState::operation_enabled:
        case axis402::PowerState::quick_stop_active:
        case axis402::PowerState::fault_reaction_active:
        case axis402::PowerState::unknown: return false;
    }
    return false;
}

bool wants_home(const Request& request, std::size_t axis) noexcept {
    return request.home && ((std::uint32_t{request.home_axes} >> axis) & 1U) != 0;
}

}  // namespace

DriveMaster::DriveMaster(const MachineConfig& machine) noexcept
    : budget_(bus_budget(machine)),
      nodes_{DriveNode(machine, 0), DriveNode(machine, 1), DriveNode(machine, 2), DriveNode(machine, 3)},
      cycle_ticks_(machine.drive_cycle_ticks > 0 ? static_cast<std::int64_t>(machine.drive_cycle_ticks) : 1) {
    const std::int64_t period = machine.control_period_ns > 0 ? machine.control_period_ns : 1;
    heartbeat_ticks_ = kHeartbeatPeriodNs / period > 0 ? kHeartbeatPeriodNs / period : 1;
}

Outcome DriveMaster::step(std::int64_t tick, std::span<const DriveFrame> received, const Request& request,
                          ServoOutputs& out) noexcept {
    if (!budget_) {
        return {};
    }
    const bool cycle = tick % cycle_ticks_ == 0;
    receive(received, tick);
    if (cycle) {
        fresh_ = true;
        for (DriveNode& node : nodes_) {
            fresh_ = (node.take_fresh() || !node.present()) && fresh_;
        }
    }
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        nodes_[axis].update(node_request(axis, request), tick, cycle);
    }
    if (cycle) {
        send_cycle(out);
    }
    send_other(tick, cycle, out);
    const Outcome result = outcome(request);
    all_enabled_ = result.all_enabled;
    return result;
}

bool DriveMaster::measured(std::int64_t tick, std::span<const DriveFrame> received, AxisPositions& place,
                           std::int64_t& t_tick) const noexcept {
    std::uint32_t seen = 0;
    for (const DriveFrame& frame : received) {
        for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
            if (const auto actual = nodes_[axis].measured(frame)) {
                place[axis] = *actual;
                seen |= 1U << axis;
            }
        }
    }
    // The SYNC of tick n goes out at t_n+1, and is answered by the beginning of tick n + 2.
    const std::int64_t newest = tick - 2;
    t_tick = newest - newest % cycle_ticks_ + 1;
    return seen == (1U << kAxisCount) - 1U && newest >= 0;
}

std::uint8_t DriveMaster::faults_told(std::span<const DriveFrame> received) const noexcept {
    unsigned told = 0;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        for (const DriveFrame& frame : received) {
            told |= nodes_[axis].present() && nodes_[axis].tells_fault(frame) ? 1U << axis : 0U;
        }
    }
    return static_cast<std::uint8_t>(told);
}

NodeRequest DriveMaster::node_request(std::size_t axis, const Request& request) const noexcept {
    return {.power = request.power,
            .home = wants_home(request, axis),
            .reset = request.reset,
            .quick_stop = request.quick_stop,
            .may_follow = all_enabled_ && request.power,
            .target = request.target[axis]};
}

void DriveMaster::receive(std::span<const DriveFrame> received, std::int64_t tick) noexcept {
    for (const DriveFrame& frame : received) {
        for (DriveNode& node : nodes_) {
            if ((frame.id & canopen::kNodeMask) == node.node()) {
                node.receive(frame, tick);
            }
        }
    }
}

void DriveMaster::send_cycle(ServoOutputs& out) noexcept {
    for (const DriveNode& node : nodes_) {
        append(out, node.rpdo_frame());
    }
    append(out, canopen::sync());
}

void DriveMaster::send_other(std::int64_t tick, bool cycle, ServoOutputs& out) noexcept {
    if (tick % heartbeat_ticks_ == 0) {
        append(out, canopen::heartbeat(canopen::kMasterNode, canopen::NmtState::operational));
    }
    // Kept out of the ticks with a SYNC, where the drives answer with their PDOs.
    const bool sdo_allowed = !cycle || cycle_ticks_ == 1;
    for (DriveNode& node : nodes_) {
        append(out, node.nmt_frame());
        if (sdo_allowed) {
            append(out, node.sdo_frame(tick));
        }
    }
}

AxisStatus DriveMaster::status(const DriveNode& node) const noexcept {
    return {.present = node.present(),
            .enabled = node.enabled(),
            .follows = node.follows(),
            .homed = node.present() && node.homing().homed(),
            .fault = node.fault(),
            .homing_failed = node.homing().failed(),
            .error_code = node.error_code(),
            .actual = node.actual(),
            .statusword = node.statusword()};
}

Outcome DriveMaster::outcome(const Request& request) const noexcept {
    Outcome result;
    result.all_present = true;
    result.all_enabled = true;
    result.all_follow = true;
    result.all_disabled = true;
    result.homing_done = request.home;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const DriveNode& node = nodes_[axis];
        result.axis[axis] = status(node);
        result.all_present = result.all_present && node.present();
        result.all_enabled = result.all_enabled && node.enabled();
        result.all_follow = result.all_follow && node.follows();
        result.all_disabled = result.all_disabled && (!node.present() || unpowered(node.power_state()));
        const bool pending = wants_home(request, axis) && !node.homing().done();
        result.homing_done = result.homing_done && !pending;
    }
    result.actual_fresh = fresh_ && result.all_present;
    return result;
}

}  // namespace sc::drives
