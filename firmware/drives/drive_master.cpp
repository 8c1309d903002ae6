// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/drive_master.hpp"

namespace sc::drives {
namespace {

[[gnu::noinline]] void append(ServoOutputs& out, const DriveFrame& frame) noexcept {
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

[[gnu::cold]] DriveMaster::DriveMaster(const MachineConfig& machine, const DrivePlan& plan) noexcept
    : budget_(bus_budget(machine, plan)),
      nodes_{DriveNode(machine, 0, plan), DriveNode(machine, 1, plan), DriveNode(machine, 2, plan),
             DriveNode(machine, 3, plan)},
      cycle_ticks_(static_cast<std::int64_t>(machine.drive_cycle_ticks)) {
    const std::int64_t period = machine.control_period_ns > 0 ? machine.control_period_ns : 1;
    heartbeat_ticks_ = Period(kHeartbeatPeriodNs / period);
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const DriveOptions& options = plan.drive[axis];
        buses_ = static_cast<std::uint8_t>(buses_ | (options.bus == 0 ? 1U : 2U));
        any_paired_ = any_paired_ || options.paired;
        pairs_[axis] = options.paired ? target_pair(plan, axis) : TargetPair{};
    }
}

Outcome DriveMaster::step(std::int64_t tick, std::span<const DriveFrame> received, const Request& request,
                          ServoOutputs& out) noexcept {
    // A conversion, not a return from within: the outcome is made where the caller wants it.
    return budget_ ? run(tick, received, request, out) : Outcome{};
}

Outcome DriveMaster::run(std::int64_t tick, std::span<const DriveFrame> received, const Request& request,
                         ServoOutputs& out) noexcept {
    const bool cycle = cycle_ticks_.begins(tick);
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
    t_tick = newest - newest % cycle_ticks_.count() + 1;
    return seen == (1U << kAxisCount) - 1U && newest >= 0;
}

std::uint8_t DriveMaster::faults_told(std::span<const DriveFrame> received) const noexcept {
    unsigned told = 0;
    for (const DriveFrame& frame : received) {
        for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
            const DriveNode& node = nodes_[axis];
            told |= node.sent(frame) && node.present() && node.tells_fault(frame) ? 1U << axis : 0U;
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
            if (node.sent(frame)) {
                node.receive(frame, tick);
            }
        }
    }
}

void DriveMaster::send_targets(ServoOutputs& out) noexcept {
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const DriveNode& node = nodes_[axis];
        const TargetPair pair = pairs_[axis];
        const DriveNode& other = nodes_[pair.second];
        if (node.paired() && pair.first == axis && (node.present() || other.present())) {
            append(out, canopen::rpdo_pair(node.address(), node.target_counts(), other.target_counts()));
        }
    }
}

/// One a cycle, as the budget has it; a quick stop goes first.
[[gnu::noinline]] void DriveMaster::send_controlword(std::uint16_t bus_bit, ServoOutputs& out) noexcept {
    DriveNode* chosen = nullptr;
    for (DriveNode& node : nodes_) {
        if (node.bus_bit() == bus_bit && node.controlword_due() &&
            (chosen == nullptr || (node.urgent() && !chosen->urgent()))) {
            chosen = &node;
        }
    }
    if (chosen != nullptr) {
        append(out, chosen->controlword_frame());
    }
}

void DriveMaster::send_cycle(ServoOutputs& out) noexcept {
    for (const DriveNode& node : nodes_) {
        append(out, node.rpdo_frame());
    }
    if (any_paired_) {
        send_targets(out);
        send_controlword(0, out);
        send_controlword(kSecondDriveBus, out);
    }
    append_on_buses(out, canopen::sync());
}

[[gnu::noinline]] void DriveMaster::append_on_buses(ServoOutputs& out, const DriveFrame& frame) const noexcept {
    for (std::uint16_t bus = 0; bus < kDriveBuses; ++bus) {
        if (((buses_ >> bus) & 1U) != 0) {
            DriveFrame here = frame;
            here.id = static_cast<std::uint16_t>(frame.id | (bus == 0 ? 0U : kSecondDriveBus));
            append(out, here);
        }
    }
}

void DriveMaster::send_other(std::int64_t tick, bool cycle, ServoOutputs& out) noexcept {
    if (heartbeat_ticks_.begins(tick)) {
        append_on_buses(out, canopen::heartbeat(canopen::kMasterNode, canopen::NmtState::operational));
    }
    // Kept out of the ticks with a SYNC, where the drives answer with their PDOs; with a SYNC in each tick, few and in
    // turn.
    const bool each = cycle_ticks_.count() == 1;
    const std::size_t turn = each ? static_cast<std::size_t>(tick / kServiceTicks) % kAxisCount : 0;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        DriveNode& node = nodes_[axis];
        if (node.nmt_due()) {
            append(out, node.nmt_frame(tick / cycle_ticks_.count()));
        }
        const bool in_turn = each && axis == turn && tick % kServiceTicks == 0;
        if (!cycle || in_turn) {
            append(out, node.sdo_frame(tick));
        }
    }
}

[[gnu::noinline]] AxisStatus DriveMaster::status(const DriveNode& node) const noexcept {
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
    Outcome result{.axis = {status(nodes_[0]), status(nodes_[1]), status(nodes_[2]), status(nodes_[3])},
                   .all_present = true,
                   .all_enabled = true,
                   .all_follow = true,
                   .all_disabled = true,
                   .homing_done = request.home};
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const DriveNode& node = nodes_[axis];
        const AxisStatus& seen = result.axis[axis];
        result.all_present = result.all_present && seen.present;
        result.all_enabled = result.all_enabled && seen.enabled;
        result.all_follow = result.all_follow && seen.follows;
        result.all_disabled = result.all_disabled && (!seen.present || unpowered(node.power_state()));
        const bool pending = wants_home(request, axis) && !node.homing().done();
        result.homing_done = result.homing_done && !pending;
    }
    result.actual_fresh = fresh_ && result.all_present;
    return result;
}

}  // namespace sc::drives
