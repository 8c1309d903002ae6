// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "boards/sim/controller_host.hpp"

namespace sc::faults {

/// What goes wrong on the controller's own board, from now on.
struct BoardTrouble {
    bool reset = false;           ///< the watchdog starts the controller anew, once
    bool no_plan = false;         ///< the planner gets no time
    bool rounding = false;        ///< the processor rounds upwards
    bool bus_off = false;         ///< nothing comes or goes on the drive bus
    int missed_ticks = 0;         ///< so many control periods are not served
    int jump_axis = -1;           ///< the place that this axis' drive reports is off
    int shoved_axis = -1;         ///< the target that this axis' drive gets is off
    std::int32_t off_counts = 0;  ///< by so much
};

/// The controller on a board that things can go wrong on.
class BenchBoard final : public sim::ControllerHost {
public:
    BenchBoard(const MachineConfig& machine, std::uint32_t boot_id, RetainedMemory* retained);

    void tick(const ServoInputs& inputs, ServoOutputs& outputs) override;
    void fit_key(const link::SealSecret& secret) override { controller_->fit_key(secret); }
    [[nodiscard]] Fault first_fault() const override { return controller_->first_fault().fault; }

    BoardTrouble trouble;

private:
    [[nodiscard]] std::span<const DriveFrame> received(std::span<const DriveFrame> frames);
    void send(ServoOutputs& outputs) const;

    MachineConfig machine_;
    std::uint32_t boot_id_;
    RetainedMemory* retained_;
    std::unique_ptr<Controller> controller_;
    std::vector<DriveFrame> frames_;
    int dead_ticks_ = 0;
};

}  // namespace sc::faults
