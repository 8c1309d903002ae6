// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "boards/stm32h743/io/control_clock.hpp"
#include "boards/stm32h743/io/digital_port.hpp"
#include "boards/stm32h743/link/drive_ports.hpp"
#include "boards/stm32h743/link/host_link.hpp"
#include "boards/stm32h743/link/sensor_port.hpp"
#include "boards/stm32h743/optics/galvo_status.hpp"
#include "boards/stm32h743/optics/galvo_wave.hpp"
#include "boards/stm32h743/optics/gate_wave.hpp"
#include "boards/stm32h743/optics/power_strobes.hpp"
#include "boards/stm32h743/optics/safety_lines.hpp"
#include "firmware/controller/controller.hpp"

namespace sc::stm32h743 {

/// What the loop is wired to; all of it outlives the loop. Links, drives, sensors and source have been started.
struct BoardParts {
    Controller& controller;
    ServoOutputs& outputs;
    HostLink& host;
    DrivePorts& drives;
    GalvoWave& galvo;
    GalvoStatus& status;
    GateWave& gate;
    PowerStrobes& power;
    SafetyLines& lines;
    ControlClock& clock;
    std::array<SensorPort*, kSensorBuses> sensors{};
};

/// One controller on its board. The galvo's DMA is the clock: a tick begins with each swap of its buffers. At t_n: the
/// outputs of tick n − 1 that have no hardware of their own to wait in leave (drives, slow lines, sensors),
/// what has come is taken, the controller's step n runs, and its frames, runs and strobes are laid where hardware takes
/// them at t_n+1.
///
/// Contexts, each may break into those below it:
///
///     on_edge            edge of e-stop or interlock
///     on_guard           TIM7, 10 kHz            on_sensor    USARTs of the sensors
///     on_window          the galvo's DMA, 1 kHz; asks for `tick`
///     tick               1 kHz
///     plan               between ticks
class BoardLoop {
public:
    enum class Start : std::uint8_t { ok, lines, digital, status, galvo, power, gate, clock };

    BoardLoop(const MachineConfig& machine, const BoardParts& parts) noexcept : machine_(machine), parts_(parts) {}

    /// From here on the galvo's line runs, and ticks come; the first one is due 1 ms later.
    [[nodiscard]] Start start() noexcept;

    void on_edge() noexcept;
    void on_guard() noexcept;
    void on_sensor(std::size_t bus) noexcept;
    void on_window() noexcept;
    /// What the last window has made due. Nothing when none is.
    void tick() noexcept;
    /// The tick's share of planning, which `tick` may break into. True: a whole tick has been done in time, and the
    /// watchdogs may be fed. Nothing, and false, until the next tick has run.
    [[nodiscard]] bool plan() noexcept;

    /// A tick did not end before the next but one was due: everything is off, nothing runs any more, and the watchdogs
    /// starve.
    [[nodiscard]] bool failed() const noexcept { return failed_; }
    [[nodiscard]] const ServoOutputs& latest() const noexcept { return parts_.outputs; }
    /// Tick that comes next.
    [[nodiscard]] std::int64_t next_tick() const noexcept { return tick_; }
    /// Periods of the guard in which it closed the gate for a cause. Monotonic.
    [[nodiscard]] std::uint32_t vetoes() const noexcept { return vetoes_; }

private:
    [[nodiscard]] std::int64_t now_ns() const noexcept { return parts_.clock.now_ns(windows_ - 1); }
    void act() noexcept;
    void take_inputs(ServoInputs& in) noexcept;
    void lay_out(const ServoOutputs& out) noexcept;
    void fail() noexcept;
    void close(std::uint8_t causes) noexcept;

    MachineConfig machine_;
    BoardParts parts_;
    std::array<std::uint8_t, kLinkBytesPerTick> link_rx_{};
    std::int64_t tick_ = 0;
    std::int64_t planned_ = 0;              ///< ticks whose planning is done
    std::atomic<std::int32_t> windows_{0};  ///< begun since the start; 24 days
    std::atomic<bool> allowed_{false};      ///< pulses may leave in this window
    std::atomic<bool> next_allowed_{false};
    std::atomic<bool> closed_{false};  ///< the guard has closed the gate since the controller was told of causes
    std::atomic<std::uint8_t> causes_{0};
    std::atomic<bool> estop_closed_{false};
    std::atomic<bool> interlock_closed_{false};
    std::atomic<std::uint16_t> status_{0};
    std::atomic<bool> failed_{false};
    std::uint32_t vetoes_ = 0;
};

}  // namespace sc::stm32h743
