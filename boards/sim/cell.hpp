// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "boards/memory/retained_file.hpp"
#include "boards/replay/log_file.hpp"
#include "boards/sim/cell_report.hpp"
#include "boards/sim/cell_traces.hpp"
#include "boards/sim/controller_host.hpp"
#include "boards/sim/link_line.hpp"
#include "boards/sim/lock_step.hpp"
#include "boards/sim/parameter_file.hpp"
#include "boards/sim/plant/cell_plant.hpp"
#include "boards/sim/world/world.hpp"
#include "firmware/link/seal_gate.hpp"
#include "shared/codes/state.hpp"
#include "shared/machine/machine.hpp"

namespace sc::sim {

struct CellOptions {
    MachineConfig machine = reference_machine();
    std::filesystem::path world;  ///< world file
    std::filesystem::path out;    ///< directory of the traces, created; empty = write nothing
    /// File of what the controller keeps without power; beside it FILE.parameters. Empty = it keeps nothing.
    std::filesystem::path memory{};
    std::filesystem::path record{};  ///< log of the controller's inputs; empty = none
    std::uint64_t record_limit_bytes = 100'000'000;
    std::vector<FaultEvent> script{};
    std::uint32_t baud = 921'600;
    LinkCarrier carrier = LinkCarrier::serial;
    std::uint32_t boot_id = 1;
    std::optional<link::SealSecret> seal{};  ///< the controller takes sealed commands only
    bool command_trace = false;              ///< write command.trace too
    PulseSink on_pulse{};                    ///< called besides the trace; may be empty
    PlantDrives drives{};                    ///< the controller has to be made for their buses
    MakeController controller = make_local_controller;
};

/// The whole cell in virtual time: controller, plant, world, link wire, script of faults, traces. One thread, no clock
/// but its own: the same calls give the same bytes. A dark tick costs some microseconds.
class SimCell final : public LockStepCell {
public:
    /// Throws WorldError, std::invalid_argument (machine, record_limit_bytes), std::system_error (directory, record).
    explicit SimCell(const CellOptions& options);

    /// Bytes for the controller, at now(); they go in no faster than the wire allows.
    void push_link(std::span<const std::uint8_t> bytes) override;
    std::size_t take_link(std::vector<std::uint8_t>& out) override;
    void tick() override;
    /// Lives on without a host until the state is fault, idle, disabled or boot, or for 30 s of its time.
    void run_out();

    [[nodiscard]] std::int64_t now_ns() const noexcept override { return tick_ * options_.machine.control_period_ns; }
    [[nodiscard]] State state() const noexcept { return static_cast<State>(latest().state); }
    [[nodiscard]] std::uint64_t faults() const noexcept { return latest().faults; }
    /// Outputs of the last tick.
    [[nodiscard]] const ServoOutputs& latest() const noexcept { return *outputs_[newest_]; }
    [[nodiscard]] CellPlant& plant() noexcept { return plant_; }
    [[nodiscard]] const CellPlant& plant() const noexcept { return plant_; }
    [[nodiscard]] const World& world() const noexcept { return world_; }

    [[nodiscard]] CellReport report() const;
    /// The log of the inputs; nullptr if none is kept.
    [[nodiscard]] const replay::LogFile* record() const noexcept { return record_.get(); }
    /// Closes the traces and the log and writes cell.json. The cell must not tick afterwards.
    void close();

private:
    void step_controller();
    void carry_link();
    void note_state();

    CellOptions options_;
    World world_;
    CellPlant plant_;
    CellTraces traces_;
    std::unique_ptr<LinkLine> link_;
    std::vector<std::uint8_t> link_rx_;
    std::vector<std::uint8_t> link_tx_;
    memory::RetainedFile retained_;
    ParameterFile parameters_;
    StartingMachine start_;
    std::unique_ptr<ControllerHost> controller_;
    std::unique_ptr<replay::LogFile> record_;
    std::array<std::unique_ptr<ServoOutputs>, 2> outputs_;
    std::size_t newest_ = 0;
    std::int64_t tick_ = 0;
    int ticks_at_rest_ = 0;
};

}  // namespace sc::sim
