// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <memory>

#include <gtest/gtest.h>

#include "boards/stm32h743/optics/gate_wave.hpp"
#include "boards/stm32h743/optics/safety_lines.hpp"
#include "firmware/safety/frame_guard.hpp"
#include "tests/stm32h743/model/advanced_timer.hpp"
#include "tests/stm32h743/model/external_lines.hpp"

namespace sc::stm32h743 {
namespace {

/// The lines, the guard of the firmware and the gate, as an image puts them together; the break input stays silent.
TEST(GuardGate, AnOpenLineShutsTheGateAtItsEdgeAndKeepsItShut) {
    model::Machine machine;
    model::ClockGates clocks(machine);
    model::EdgePort port(machine, clocks);
    model::DmaModel dma(machine, clocks, model::DmaModel::Which::second);
    model::AdvancedTimer timer(machine, clocks, dma, port);
    model::PortChoice choice(machine, clocks);
    model::EdgeLines edges(machine, choice, port);
    model::PeriodTimer period(machine, clocks);
    const auto buffers = std::make_unique<GateBuffers>();
    machine.attach(model::ClockGates::kBase, 0x400, clocks);
    machine.attach(model::EdgePort::kBase, 0x400, port);
    machine.attach(model::DmaModel::kBase2, 0x400, dma);
    machine.attach(model::DmaModel::kMuxBase2, 0x20, dma.mux);
    machine.attach(model::AdvancedTimer::kBase, 0x400, timer);
    machine.attach(model::EdgeLines::kBase, 0x400, edges);
    machine.attach(model::PortChoice::kBase, 0x400, choice);
    machine.attach(model::PeriodTimer::kBase, 0x400, period);
    machine.map_memory(0x30020000, std::span(reinterpret_cast<std::uint8_t*>(buffers.get()), sizeof *buffers));
    timer.set_break_pin(true);
    edges.set_pin(7, true);
    edges.set_pin(8, true);

    GateWave wave(*buffers);
    SafetyLines lines;
    std::uint8_t causes = 0;
    const auto guard = [&](SafetyLines::State state) {
        GuardInputs inputs;
        inputs.gate_allowed = true;
        inputs.galvo_status = kGalvoStatusOk;
        inputs.digital.estop_closed = state.estop_closed;
        inputs.digital.interlock_closed = state.interlock_closed;
        inputs.digital.laser_ready = true;
        inputs.digital.laser_no_alarm = true;
        inputs.digital.shutter_open = true;
        inputs.digital.key_production = true;
        const GuardVeto veto = safety::frame_guard(inputs);
        causes = static_cast<std::uint8_t>(causes | veto.causes);
        if (veto.close_gate) {
            wave.shut();
        }
    };
    machine.on_interrupt(model::EdgeLines::kInterrupt5To9, [&] { guard(lines.edge()); });
    machine.on_interrupt(model::PeriodTimer::kInterrupt, [&] { guard(lines.guard_period()); });

    machine.advance_to(1'000);
    ASSERT_TRUE(wave.start(0));
    ASSERT_TRUE(lines.start());
    LaserRun run;
    run.t0_ns = 1'000'000;
    run.period_ns256 = 2'000 * 256;
    run.count = 400;
    ASSERT_TRUE(wave.fill(std::span(&run, 1)));
    machine.advance_to(timer.started_ns() + 350'000);
    causes = 0;  // of the first period
    ASSERT_TRUE(wave.arm());
    machine.advance_to(timer.started_ns() + 1'450'000);
    ASSERT_EQ(causes, 0);
    ASSERT_TRUE(wave.check());
    edges.set_pin(7, false);
    machine.advance_to(timer.started_ns() + 1'450'500);
    (void)wave.check();
    machine.advance_to(timer.started_ns() + 1'850'000);
    EXPECT_EQ(causes, static_cast<std::uint8_t>(GuardCause::estop));
    ASSERT_FALSE(timer.levels.empty());
    EXPECT_FALSE(timer.levels.back().trigger || timer.levels.back().gate);
    EXPECT_LE(timer.levels.back().count, (1'450'000 + 100'000) * 6 / 25);
    // Whoever arms it again with the line open has it for a period of the guard at most.
    ASSERT_TRUE(wave.arm());
    machine.advance_to(machine.now_ns() + 100'100);
    EXPECT_FALSE(wave.check());
    EXPECT_EQ(machine.violations_text(), "");
}

}  // namespace
}  // namespace sc::stm32h743
