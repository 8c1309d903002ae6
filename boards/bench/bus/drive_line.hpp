// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "boards/bench/bus/bus_load.hpp"
#include "boards/sim/carrier/can_bus.hpp"
#include "boards/sim/plant/drive.hpp"
#include "firmware/drives/drive_master.hpp"
#include "firmware/hal/io.hpp"

namespace sc::bench {

/// Drives on one or two bit-timed buses, enabled and moving, with the drive master or with single nodes of it (for
/// other numbers of axes than the cell's four, and for buses that the master refuses).
class DriveLine {
public:
    DriveLine(const BusCase& which, bool by_master, bool bit_timed);

    void step(std::int64_t tick);
    [[nodiscard]] bool ready() const noexcept { return ready_; }
    void count_from_now() { counts_ = {}; }
    /// Of the bus that carried more.
    [[nodiscard]] FrameCounts counts() const;

private:
    struct Axis {
        MachineConfig machine;
        DrivePlan plan;
        std::size_t index = 0;  ///< in them
        drives::DriveNode node;
        std::size_t group = 0;
    };
    void make_axes(const BusCase& which);
    void ask_master(std::int64_t tick, ServoOutputs& out);
    void ask_nodes(std::int64_t tick, ServoOutputs& out);
    void send_pairs(ServoOutputs& out);
    void carry(std::int64_t tick, const ServoOutputs& out);
    void count(const DriveFrame& frame);
    [[nodiscard]] std::int64_t target(std::size_t axis, std::int64_t tick) const;

    BusCase which_;
    bool bit_timed_;
    bool ready_ = false;
    bool all_enabled_ = false;
    std::vector<Axis> axes_;
    std::vector<std::int64_t> start_;
    std::vector<sim::SimDrive> drives_;
    std::unique_ptr<drives::DriveMaster> master_;
    drives::Outcome outcome_{};
    std::vector<sim::CanBus> buses_;
    std::vector<DriveFrame> received_;
    std::array<FrameCounts, 2> counts_{};
    std::unique_ptr<ServoOutputs> out_ = std::make_unique<ServoOutputs>();
};

}  // namespace sc::bench
