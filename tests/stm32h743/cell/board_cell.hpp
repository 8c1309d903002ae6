// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "boards/sim/events/event_player.hpp"
#include "boards/sim/lock_step.hpp"
#include "boards/sim/plant/galvo.hpp"
#include "boards/sim/world/world_spec.hpp"
#include "boards/stm32h743/loop/board_loop.hpp"
#include "firmware/controller/controller.hpp"
#include "tests/stm32h743/cell/chip.hpp"
#include "tests/stm32h743/cell/waves.hpp"
#include "tests/stm32h743/cell/wires.hpp"

namespace sc::stm32h743::cell {

struct BoardCellReport {
    sim::EventReport events;
    std::uint64_t frames = 0;        ///< of the galvo, as its lines showed them
    std::uint64_t frames_wrong = 0;  ///< not the controller's word, or not at its time
    std::uint64_t triggers = 0;      ///< as the line showed them
    std::uint64_t triggers_wrong =
        0;                          ///< of those asked for and those seen: not the other's, or more than a count apart
    std::uint64_t pulses = 0;       ///< triggers with an open gate
    std::uint64_t strobes = 0;      ///< of the power byte
    std::uint64_t power_wrong = 0;  ///< bad strobes, and runs with another byte in force than theirs
    std::uint64_t lines_wrong = 0;  ///< ticks in which a slow output was not as asked
    std::uint64_t unsent = 0;       ///< frames to the drives, bytes to the host
    unsigned bus_errors = 0;        ///< on both wires, as any node saw them
    bool failed = false;            ///< the loop has stopped itself
    std::string violations;         ///< of what the chip's peripherals allow; empty
};
[[nodiscard]] std::string to_json(const BoardCellReport& report);

/// The board's loop with its drivers on the modelled chip, wired by two modelled CAN buses to a host and to the drives
/// of the simulated cell, by pins to mirrors, laser, shutter and safety chain. What leaves by pins is compared with
/// what the controller asked for. Virtual time; a second of it costs about one of real time.
class BoardCell final : public sim::LockStepCell {
public:
    struct Options {
        MachineConfig machine = reference_machine();
        bool host_fd = true;
    };
    BoardCell(const sim::WorldSpec& world, const Options& options);

    void push_link(std::span<const std::uint8_t> bytes) override { host_.push(bytes); }
    std::size_t take_link(std::vector<std::uint8_t>& out) override { return host_.take(out); }
    void tick() override;
    [[nodiscard]] std::int64_t now_ns() const override { return loop_.next_tick() * machine_.control_period_ns; }

    [[nodiscard]] State state() const { return static_cast<State>(loop_.latest().state); }
    [[nodiscard]] std::uint64_t faults() const { return loop_.latest().faults; }
    [[nodiscard]] Controller& controller() { return controller_; }
    [[nodiscard]] BoardLoop& loop() { return loop_; }
    [[nodiscard]] Chip& chip() { return chip_; }
    [[nodiscard]] Drives& drives() { return drives_; }
    [[nodiscard]] sim::GalvoPlant& head() { return head_; }
    /// E-stop and interlock.
    void set_lines(bool estop_closed, bool interlock_closed);
    /// Triggers that have left with an open gate.
    [[nodiscard]] std::uint64_t pulses() const { return pulses_; }
    /// The same, with those since the last tick.
    [[nodiscard]] std::uint64_t seen_pulses() {
        see_pins();
        return pulses_;
    }
    /// Compares what is left to compare.
    [[nodiscard]] BoardCellReport report();

private:
    void start();
    void see_pins();
    void see_edge(std::uint32_t before, std::uint32_t after);
    void live_outside();
    void drive_inputs();

    MachineConfig machine_;
    Chip chip_;
    HostNode host_;
    Drives drives_;
    sim::GalvoPlant head_;
    sim::EventPlayer player_;

    Fdcan host_port_{kHostCan};
    Fdcan drive_port_{kDriveCan};
    HostCan link_;
    DrivePorts drive_ports_{drive_port_, nullptr};
    GalvoWave galvo_{*chip_.galvo_buffers};
    GalvoStatus status_{*chip_.status_buffer};
    GateWave gate_{*chip_.gate_buffers};
    ControlClock clock_;
    PowerStrobes power_{*chip_.power_buffers, clock_, machine_.laser};
    SafetyLines lines_;
    ServoOutputs outputs_;
    Controller controller_;
    BoardLoop loop_;

    std::int64_t origin_ns_ = 0;  ///< machine time of the control time 0
    GalvoLine galvo_line_;
    TriggerLine trigger_line_;
    std::deque<std::uint64_t> frames_due_;  ///< both words of each
    std::vector<TriggerLine::Trigger> triggers_;
    std::vector<LaserRun> runs_;
    PowerLine power_line_;
    DigitalOutputs asked_;
    std::uint64_t pulses_ = 0;
    BoardCellReport report_;
};

}  // namespace sc::stm32h743::cell
