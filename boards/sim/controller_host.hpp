// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "boards/sim/board_figures.hpp"
#include "firmware/controller/controller.hpp"
#include "firmware/hal/io.hpp"
#include "firmware/link/seal_gate.hpp"
#include "firmware/motion/path_motion.hpp"
#include "shared/machine/machine.hpp"

namespace sc::sim {

/// Where the cell's controller runs: in this process, or on a board that lives in lock-step with the cell.
class ControllerHost {
public:
    ControllerHost() = default;
    ControllerHost(const ControllerHost&) = delete;
    ControllerHost& operator=(const ControllerHost&) = delete;
    virtual ~ControllerHost() = default;

    /// One control period: servo_step, then the tick's share of plan_step. `outputs` comes in cleared. Throws
    /// std::runtime_error when the controller no longer answers.
    virtual void tick(const ServoInputs& inputs, ServoOutputs& outputs) = 0;
    /// Where the controller keeps its parameters; once, before the first tick. A board that keeps none does nothing.
    virtual void keep_parameters_in(ParameterMemory* /*memory*/, std::uint32_t /*generation*/) {}
    /// From now on host messages count only if they are sealed; once, before the first tick.
    virtual void fit_key(const link::SealSecret& secret) = 0;
    /// The first fault since the start or the last reset.
    [[nodiscard]] virtual Fault first_fault() const = 0;
    /// Name of the board, as the folder below boards/ has it.
    [[nodiscard]] virtual std::string board() const { return "sim"; }
    /// What the board has measured so far; nullopt where nothing is. Throws as tick() does.
    [[nodiscard]] virtual std::optional<BoardFigures> figures() { return std::nullopt; }
};

/// `retained` is the memory that the cell keeps without power; it outlives the controller.
using MakeController = std::function<std::unique_ptr<ControllerHost>(const MachineConfig& machine,
                                                                     std::uint32_t boot_id, RetainedMemory* retained)>;

/// The controller in this process.
class LocalController final : public ControllerHost {
public:
    LocalController(const MachineConfig& machine, std::uint32_t boot_id, RetainedMemory* retained,
                    const DrivePlan& drives = kPlainDrives)
        : controller_(machine, boot_id, retained, drives) {}

    void tick(const ServoInputs& inputs, ServoOutputs& outputs) override {
        controller_.servo_step(inputs, outputs);
        controller_.plan_step(motion::kUnitsPerTick);
    }
    void keep_parameters_in(ParameterMemory* memory, std::uint32_t generation) override {
        controller_.keep_parameters_in(memory, generation);
    }
    void fit_key(const link::SealSecret& secret) override { controller_.fit_key(secret); }
    [[nodiscard]] Fault first_fault() const override { return controller_.first_fault().fault; }

private:
    Controller controller_;
};

[[nodiscard]] inline std::unique_ptr<ControllerHost> make_local_controller(const MachineConfig& machine,
                                                                           std::uint32_t boot_id,
                                                                           RetainedMemory* retained) {
    return std::make_unique<LocalController>(machine, boot_id, retained);
}

}  // namespace sc::sim
