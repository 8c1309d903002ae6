// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/cell/wires.hpp"

#include <algorithm>
#include <array>

namespace sc::stm32h743::cell {
namespace {

constexpr model::WireRates kHostRates{1'000'000, 5'000'000};
constexpr model::WireRates kDriveRates{1'000'000, 0};
constexpr std::int64_t kStepNs = 100'000;

}  // namespace

HostNode::HostNode(bool fd) : QueueNode(kHostRates), port_(link::kCanIdToController, fd) {}

void HostNode::push(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
        const std::size_t taken = port_.push(bytes);
        bytes = bytes.subspan(taken);
        link::LinkCanFrame frame;
        while (port_.next(frame)) {
            model::WireFrame raw;
            raw.id = frame.id;
            raw.fd = raw.fast = frame.fd;
            raw.data.assign(frame.data.begin(), frame.data.begin() + frame.size);
            queue_.push_back(raw);
        }
    }
}

void HostNode::heard(const model::WireFrame& frame, std::int64_t /*began_ns*/) {
    link::LinkCanFrame raw;
    raw.id = frame.id;
    raw.fd = frame.fd;
    raw.size = static_cast<std::uint8_t>(frame.data.size());
    std::copy(frame.data.begin(), frame.data.end(), raw.data.begin());
    std::array<std::uint8_t, link::kSerialCapacity> message{};
    const std::size_t size = port_.take(raw, message);
    received_.insert(received_.end(), message.begin(), message.begin() + static_cast<std::ptrdiff_t>(size));
}

std::size_t HostNode::take(std::vector<std::uint8_t>& out) {
    const std::size_t size = received_.size();
    out.insert(out.end(), received_.begin(), received_.end());
    received_.clear();
    return size;
}

DriveNode::DriveNode(model::Machine& machine, const sim::SimDriveOptions& options)
    : QueueNode(kDriveRates), machine_(machine), drive_(options) {}

void DriveNode::heard(const model::WireFrame& frame, std::int64_t /*began_ns*/) {
    if (frame.extended || frame.remote) {
        return;
    }
    DriveFrame taken{.id = static_cast<std::uint16_t>(frame.id), .size = static_cast<std::uint8_t>(frame.data.size())};
    std::copy(frame.data.begin(), frame.data.end(), taken.data.begin());
    drive_.receive(taken, machine_.now_ns() - origin_ns_);
    drain();
}

void DriveNode::step() {
    drive_.step_to(machine_.now_ns() - origin_ns_);
    drain();
}

void DriveNode::drain() {
    sent_.clear();
    drive_.drain(sent_);
    for (const DriveFrame& frame : sent_) {
        model::WireFrame raw;
        raw.id = frame.id;
        raw.data.assign(frame.data.begin(), frame.data.begin() + frame.size);
        queue_.push_back(raw);
    }
}

Drives::Drives(model::Machine& machine, model::CanWire& wire, const MachineConfig& config,
               const sim::WorldSpec& world) {
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        sim::SimDriveOptions options = sim::drive_options(
            config.axis[i], config.drive_cycle_ticks * config.control_period_ns, sim::kPowerUpPosition[i]);
        options.backlash = world.drives.backlash[i];
        options.servo.disturbance = world.drives.disturbance[i];
        options.servo.disturbance_frequency = world.drives.disturbance_frequency;
        nodes_.push_back(std::make_unique<DriveNode>(machine, options));
        wire.join(*nodes_.back());
    }
    machine.attach(0, 0, *this);
}

void Drives::set_origin(std::int64_t ns) {
    next_ns_ = ns + kStepNs;
    for (const std::unique_ptr<DriveNode>& node : nodes_) {
        node->set_origin(ns);
    }
}

void Drives::act(std::int64_t now_ns) {
    for (const std::unique_ptr<DriveNode>& node : nodes_) {
        node->step();
    }
    next_ns_ = now_ns + kStepNs;
}

}  // namespace sc::stm32h743::cell
