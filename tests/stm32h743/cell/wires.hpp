// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "boards/sim/plant/drive.hpp"
#include "boards/sim/world/world_spec.hpp"
#include "shared/link/can_port.hpp"
#include "shared/machine/machine.hpp"
#include "tests/stm32h743/model/can_wire.hpp"

namespace sc::stm32h743::cell {

/// A device that sends from a queue.
class QueueNode : public model::CanNode {
public:
    explicit QueueNode(model::WireRates rates) : rates_(rates) {}
    [[nodiscard]] std::int64_t ready_ns() const override { return 0; }
    [[nodiscard]] std::optional<model::WireFrame> wants() const override {
        return queue_.empty() ? std::nullopt : std::optional(queue_.front());
    }
    [[nodiscard]] model::WireRates rates() const override { return rates_; }
    void sent() override { queue_.pop_front(); }
    void failed(bool /*sender*/, model::WireError /*error*/) override { ++errors_; }
    [[nodiscard]] unsigned errors() const { return errors_; }

protected:
    std::deque<model::WireFrame> queue_;

private:
    model::WireRates rates_;
    unsigned errors_ = 0;
};

/// The host's CAN interface.
class HostNode final : public QueueNode {
public:
    explicit HostNode(bool fd);
    void push(std::span<const std::uint8_t> bytes);
    /// Appends what has come; how many bytes.
    std::size_t take(std::vector<std::uint8_t>& out);
    void heard(const model::WireFrame& frame, std::int64_t began_ns) override;

private:
    link::CanPort<65'536> port_;
    std::vector<std::uint8_t> received_;
};

/// A drive of the simulated cell, live on the bus: it takes a frame when its last bit has come, and answers by itself.
class DriveNode final : public QueueNode {
public:
    DriveNode(model::Machine& machine, const sim::SimDriveOptions& options);
    void heard(const model::WireFrame& frame, std::int64_t began_ns) override;
    /// Lives until now.
    void step();
    [[nodiscard]] sim::SimDrive& drive() { return drive_; }
    /// Machine time of the control time 0.
    void set_origin(std::int64_t ns) { origin_ns_ = ns; }

private:
    void drain();
    model::Machine& machine_;
    sim::SimDrive drive_;
    std::int64_t origin_ns_ = 0;
    std::vector<DriveFrame> sent_;
};

/// All drives, stepped each 100 us by the machine's time.
class Drives final : public model::Peripheral {
public:
    Drives(model::Machine& machine, model::CanWire& wire, const MachineConfig& config, const sim::WorldSpec& world);
    void set_origin(std::int64_t ns);
    [[nodiscard]] DriveNode& at(std::size_t axis) { return *nodes_.at(axis); }

    [[nodiscard]] std::uint32_t read(std::uint32_t /*offset*/) override { return 0; }
    void write(std::uint32_t /*offset*/, std::uint32_t /*value*/, unsigned /*bytes*/) override {}
    [[nodiscard]] std::int64_t next_ns() const override { return next_ns_; }
    void act(std::int64_t now_ns) override;

private:
    std::vector<std::unique_ptr<DriveNode>> nodes_;
    std::int64_t next_ns_ = kNever;
};

}  // namespace sc::stm32h743::cell
