// SPDX-License-Identifier: Apache-2.0
#include "boards/bench/bus/drive_line.hpp"

#include <algorithm>
#include <cmath>

#include "boards/sim/carrier/frame_bits.hpp"

namespace sc::bench {
namespace {

constexpr std::int64_t kTickNs = 1'000'000;
constexpr std::int64_t kSubstepNs = 50'000;
constexpr std::int64_t kHeartbeatTicks = 20;
constexpr double kSwing = 1e9;  ///< pm, of the axes while frames are counted

link::LinkCanFrame on_wire(const DriveFrame& frame) {
    link::LinkCanFrame wire;
    wire.id = frame.id & 0x7FFU;
    wire.size = frame.size;
    std::ranges::copy(frame.data, wire.data.begin());
    return wire;
}

DriveFrame off_wire(const link::LinkCanFrame& wire, std::size_t bus) {
    DriveFrame frame;
    frame.id = static_cast<std::uint16_t>(wire.id | (bus == 0 ? 0U : kSecondDriveBus));
    frame.size = wire.size;
    std::copy_n(wire.data.begin(), frame.data.size(), frame.data.begin());
    return frame;
}

/// By the standard's rule, not by shared/drives: a stuff bit after the first five equal bits and each four more, over
/// start, identifier, control, data and CRC.
std::uint64_t worst_bits(std::uint64_t bytes) {
    const std::uint64_t stuffed = 1 + 11 + 3 + 4 + 8 * bytes + 15;
    const std::uint64_t tail = 1 + 2 + 7 + 3;
    return stuffed + (stuffed - 1) / 4 + tail;
}

void put(ServoOutputs& out, const std::optional<DriveFrame>& frame) {
    if (frame && out.drive_tx_size < out.drive_tx.size()) {
        out.drive_tx[out.drive_tx_size++] = *frame;
    }
}

}  // namespace

DriveLine::DriveLine(const BusCase& which, bool by_master, bool bit_timed)
    : which_(which), bit_timed_(bit_timed), buses_(which.buses, sim::CanBus({}, sim::Troubles{})) {
    make_axes(which);
    const std::int64_t cycle_ns = kTickNs * static_cast<std::int64_t>(which.cycle_ticks);
    for (const Axis& axis : axes_) {
        const AxisConfig& config = axis.machine.axis[axis.index];
        sim::SimDriveOptions options = sim::drive_options(config, cycle_ns, -0.1);
        options.second_bus = axis.plan.drive[axis.index].bus == 1;
        drives_.emplace_back(options);
    }
    start_.assign(axes_.size(), 0);
    if (by_master) {
        master_ = std::make_unique<drives::DriveMaster>(axes_.front().machine, axes_.front().plan);
    }
}

/// Every four axes share a machine, since that is what a machine has.
void DriveLine::make_axes(const BusCase& which) {
    for (std::size_t i = 0; i < which.axes; ++i) {
        Axis axis;
        axis.index = i % kAxisCount;
        axis.group = i / kAxisCount;
        axis.machine = reference_machine();
        axis.machine.drive_cycle_ticks = which.cycle_ticks;
        for (std::size_t k = 0; k < kAxisCount; ++k) {
            const std::size_t number = axis.group * kAxisCount + k;
            DriveOptions& drive = axis.plan.drive[k];
            axis.machine.axis[k] = reference_machine().axis[0];
            axis.machine.axis[k].drive_node = static_cast<std::uint8_t>(number + 1);
            drive.paired = which.paired && number < which.axes;
            drive.status_every = which.status_every;
            drive.bus = static_cast<std::uint8_t>(number % which.buses);
        }
        axis.node = drives::DriveNode(axis.machine, axis.index, axis.plan);
        axes_.push_back(axis);
    }
}

std::int64_t DriveLine::target(std::size_t axis, std::int64_t tick) const {
    const double phase = 0.002 * static_cast<double>(tick) + static_cast<double>(axis);
    return start_[axis] + (ready_ ? static_cast<std::int64_t>(kSwing * (std::sin(phase))) : 0);
}

void DriveLine::ask_master(std::int64_t tick, ServoOutputs& out) {
    drives::Request request;
    request.power = true;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        start_[axis] = outcome_.axis[axis].follows ? start_[axis] : outcome_.axis[axis].actual;
        request.target[axis] = target(axis, tick);
    }
    outcome_ = master_->step(tick, received_, request, out);
    ready_ = ready_ || outcome_.all_follow;
}

void DriveLine::ask_nodes(std::int64_t tick, ServoOutputs& out) {
    const auto cycle_ticks = static_cast<std::int64_t>(which_.cycle_ticks);
    const bool cycle = tick % cycle_ticks == 0;
    for (const DriveFrame& frame : received_) {
        for (Axis& axis : axes_) {
            if ((frame.id & (0x7FU | kSecondDriveBus)) == axis.node.address()) {
                axis.node.receive(frame, tick);
            }
        }
    }
    bool all_enabled = true;
    bool all_follow = true;
    for (std::size_t i = 0; i < axes_.size(); ++i) {
        drives::DriveNode& node = axes_[i].node;
        start_[i] = node.follows() ? start_[i] : node.actual();
        node.update({.power = true, .may_follow = all_enabled_, .target = target(i, tick)}, tick, cycle);
        all_enabled = all_enabled && node.enabled();
        all_follow = all_follow && node.follows();
    }
    all_enabled_ = all_enabled;
    ready_ = ready_ || all_follow;
    for (std::uint32_t bus = 0; bus < which_.buses; ++bus) {
        DriveFrame sync;
        sync.id = static_cast<std::uint16_t>(0x080 | (bus == 0 ? 0U : kSecondDriveBus));
        DriveFrame beat = sync;
        beat.id = static_cast<std::uint16_t>(0x77F | (bus == 0 ? 0U : kSecondDriveBus));
        beat.size = 1;
        beat.data[0] = 5;
        if (tick % kHeartbeatTicks == 0) {
            put(out, beat);
        }
        if (cycle) {
            put(out, sync);
        }
    }
    for (std::size_t i = 0; i < axes_.size(); ++i) {
        drives::DriveNode& node = axes_[i].node;
        if (cycle) {
            put(out, node.rpdo_frame());
            if (node.controlword_due()) {
                put(out, node.controlword_frame());
            }
        }
        put(out, node.nmt_frame(tick / cycle_ticks));
        if (static_cast<std::size_t>(tick) % axes_.size() == i) {
            put(out, node.sdo_frame(tick));
        }
    }
    if (cycle) {
        send_pairs(out);
    }
}

void DriveLine::send_pairs(ServoOutputs& out) {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
        const Axis& axis = axes_[i];
        if (!axis.node.paired()) {
            continue;
        }
        const TargetPair pair = target_pair(axis.plan, axis.index);
        const std::size_t other = axis.group * kAxisCount + pair.second;
        if (pair.first == axis.index && (axis.node.present() || axes_[other].node.present())) {
            DriveFrame frame = drives::canopen::rpdo_pair(static_cast<std::uint8_t>(axis.node.address() & 0x7FU),
                                                          axis.node.target_counts(), axes_[other].node.target_counts());
            frame.id = static_cast<std::uint16_t>(frame.id | axis.node.bus_bit());
            put(out, frame);
        }
    }
}

void DriveLine::step(std::int64_t tick) {
    *out_ = ServoOutputs{};
    if (master_) {
        ask_master(tick, *out_);
    } else {
        ask_nodes(tick, *out_);
    }
    received_.clear();
    carry(tick, *out_);
}

void DriveLine::carry(std::int64_t tick, const ServoOutputs& out) {
    const std::int64_t t0 = (tick + 1) * kTickNs;
    std::vector<DriveFrame> sent;
    std::vector<link::LinkCanFrame> arrived;
    const auto deliver = [&](const DriveFrame& frame, std::int64_t t) {
        for (sim::SimDrive& drive : drives_) {
            drive.receive(frame, t);
        }
    };
    for (std::size_t i = 0; i < out.drive_tx_size; ++i) {
        const DriveFrame& frame = out.drive_tx[i];
        count(frame);
        if (bit_timed_) {
            buses_[(frame.id & kSecondDriveBus) != 0 ? 1 : 0].send(0, on_wire(frame), t0);
        } else {
            deliver(frame, t0);
        }
    }
    for (std::int64_t t = t0; t < t0 + kTickNs; t += kSubstepNs) {
        for (std::size_t bus = 0; bus < buses_.size() && bit_timed_; ++bus) {
            arrived.clear();
            buses_[bus].receive(1, t, arrived);
            for (const link::LinkCanFrame& frame : arrived) {
                deliver(off_wire(frame, bus), t);
            }
            arrived.clear();
            buses_[bus].receive(0, t, arrived);
            for (const link::LinkCanFrame& frame : arrived) {
                received_.push_back(off_wire(frame, bus));
            }
        }
        sent.clear();
        for (sim::SimDrive& drive : drives_) {
            drive.step_to(t);
            drive.drain(sent);
        }
        for (const DriveFrame& frame : sent) {
            count(frame);
            if (bit_timed_) {
                buses_[(frame.id & kSecondDriveBus) != 0 ? 1 : 0].send(1, on_wire(frame), t);
            } else {
                received_.push_back(frame);
            }
        }
    }
}

void DriveLine::count(const DriveFrame& frame) {
    FrameCounts& counts = counts_[(frame.id & kSecondDriveBus) != 0 ? 1 : 0];
    const unsigned id = frame.id & 0x7FFU;
    const unsigned base = id & 0x780U;
    if (id == 0x080) {
        ++counts.sync;
    } else if (base == 0x200) {
        ++counts.targets;
    } else if (base == 0x180) {
        ++counts.status;
    } else if (base == 0x700) {
        ++counts.heartbeats;
    } else {
        ++counts.other;
        return;
    }
    counts.worst_bits += worst_bits(frame.size);
    counts.wire_bits += static_cast<std::uint64_t>(sim::frame_bits(on_wire(frame)).nominal);
}

FrameCounts DriveLine::counts() const {
    return counts_[0].worst_bits >= counts_[1].worst_bits ? counts_[0] : counts_[1];
}

}  // namespace sc::bench
