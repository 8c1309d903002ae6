// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "boards/linux_rt/drive_bus.hpp"
#include "boards/linux_rt/host_link.hpp"
#include "boards/linux_rt/laser_head.hpp"
#include "boards/linux_rt/lines.hpp"
#include "boards/rs485/modbus_port.hpp"
#include "firmware/controller/controller.hpp"

namespace sc::linux_rt {

/// What a control loop is wired to; all of it outlives the loop.
struct LoopParts {
    DriveBus* drives = nullptr;
    HostLink* link = nullptr;
    LinePort* lines = nullptr;
    LaserHead* head = nullptr;
    std::array<rs485::ModbusPort*, kSensorBuses> sensors{};  ///< null: nothing on that bus
};

struct LoopReport {
    State state = State::boot;
    Fault first_fault = Fault::none;
    std::int64_t ticks = 0;
    std::uint64_t vetoes = 0;
    LineCounters lines;
};

/// One controller and its board, a tick at a time. Knows no clock: whoever calls `tick` keeps the period. After the
/// constructor it neither allocates nor blocks.
///
/// At t_n: what has come is taken; then the outputs of tick n − 1 leave, which are to act from t_n on; then the
/// controller's step n, the guard, and what leaves at once (link, laser runs with their times, cancel); then the plan
/// step.
class ControlLoop {
public:
    ControlLoop(const MachineConfig& machine, std::uint32_t boot_id, RetainedMemory* retained, const LoopParts& parts,
                const DrivePlan& drives = kPlainDrives);

    void tick() noexcept;
    /// From the next tick on the e-stop chain reads open for the controller: it cancels the laser, brings the axes to
    /// rest on their path and takes their power away.
    void stop() noexcept { stopping_ = true; }
    /// The axes stand without power, or there was nothing to bring to rest.
    [[nodiscard]] bool stopped() const noexcept;
    /// Outputs off, gate shut. The loop must not tick afterwards.
    void make_safe() noexcept;
    /// Whether all that the last tick has asked of drives and head has been answered.
    [[nodiscard]] bool settled() noexcept { return parts_.drives->answered() && parts_.head->settled(); }

    [[nodiscard]] Controller& controller() noexcept { return controller_; }
    [[nodiscard]] const ServoOutputs& latest() const noexcept { return *outputs_[newest_]; }
    [[nodiscard]] LoopReport report() const noexcept;
    /// Tick that comes next.
    [[nodiscard]] std::int64_t next_tick() const noexcept { return tick_; }

private:
    void take_inputs(ServoInputs& in) noexcept;
    void act() noexcept;
    void guard(const ServoInputs& in, InputBits worst) noexcept;

    MachineConfig machine_;
    LoopParts parts_;
    Controller controller_;
    Lines lines_;
    FixedOptics optics_;
    std::array<std::unique_ptr<ServoOutputs>, 2> outputs_;
    std::size_t newest_ = 0;
    std::array<std::uint8_t, kLinkBytesPerTick> link_rx_{};
    std::int64_t tick_ = 0;
    std::uint8_t causes_ = 0;  ///< of the guard since the last tick
    bool vetoed_ = false;
    bool stopping_ = false;
    std::uint64_t vetoes_ = 0;
};

}  // namespace sc::linux_rt
