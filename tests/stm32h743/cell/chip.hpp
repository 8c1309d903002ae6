// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "boards/stm32h743/optics/galvo_status.hpp"
#include "boards/stm32h743/optics/galvo_wave.hpp"
#include "boards/stm32h743/optics/gate_wave.hpp"
#include "boards/stm32h743/optics/power_strobes.hpp"
#include "tests/stm32h743/model/advanced_timer.hpp"
#include "tests/stm32h743/model/can_wire.hpp"
#include "tests/stm32h743/model/external_lines.hpp"
#include "tests/stm32h743/model/fdcan.hpp"
#include "tests/stm32h743/model/slow_lines.hpp"
#include "tests/stm32h743/model/status_spi.hpp"

namespace sc::stm32h743::cell {

/// The chip's peripherals as the board's loop uses them, each at its address.
struct Chip {
    Chip() {
        machine.attach(model::ClockGates::kBase, 0x400, clocks);
        machine.attach(model::EdgePort::kBase, 0x400, port_e);
        machine.attach(model::DmaModel::kBase, 0x400, dma1);
        machine.attach(model::DmaModel::kBase2, 0x400, dma2);
        machine.attach(model::DmaModel::kMuxBase, 0x20, dma1.mux);
        machine.attach(model::DmaModel::kMuxBase2, 0x20, dma2.mux);
        machine.attach(model::BasicTimer::kBase, 0x400, tim6);
        machine.attach(model::AdvancedTimer::kBase, 0x400, tim1);
        machine.attach(model::EdgeLines::kBase, 0x400, exti);
        machine.attach(model::PortChoice::kBase, 0x400, syscfg);
        machine.attach(model::PeriodTimer::kBase, 0x400, tim7);
        machine.map_memory(0x30000000, bytes(*galvo_buffers));
        machine.map_memory(0x30010000, bytes(*status_buffer));
        machine.map_memory(0x30020000, bytes(*gate_buffers));
        machine.map_memory(0x30038000, bytes(*power_buffers));
    }

    model::Machine machine;
    model::ClockGates clocks{machine};
    model::EdgePort port_e{machine, clocks};
    model::SlowPort port_c{machine, clocks, 2};
    model::SlowPort port_d{machine, clocks, 3};
    model::SlowPort port_f{machine, clocks, 5};
    model::SlowPort port_g{machine, clocks, 6};
    model::DmaModel dma1{machine, clocks};
    model::DmaModel dma2{machine, clocks, model::DmaModel::Which::second};
    model::BasicTimer tim6{machine, clocks, dma1};
    model::AdvancedTimer tim1{machine, clocks, dma2, port_e};
    model::Counter tim5{machine, clocks, &dma2};
    model::StatusSpi spi3{machine, clocks, dma1, port_c};
    model::StatusLine status_line{spi3};
    model::PortChoice syscfg{machine, clocks};
    model::EdgeLines exti{machine, syscfg, port_e};
    model::PeriodTimer tim7{machine, clocks};
    model::FdcanRam can_ram{machine, clocks};
    model::CanWire host_wire{machine};
    model::CanWire drive_wire{machine};
    model::FdcanModel fdcan1{machine, clocks, can_ram, host_wire, model::FdcanModel::kFdcan1};
    model::FdcanModel fdcan2{machine, clocks, can_ram, drive_wire, model::FdcanModel::kFdcan2};
    std::unique_ptr<GalvoBuffers> galvo_buffers = std::make_unique<GalvoBuffers>();
    std::unique_ptr<GateBuffers> gate_buffers = std::make_unique<GateBuffers>();
    std::unique_ptr<StatusBuffer> status_buffer = std::make_unique<StatusBuffer>();
    std::unique_ptr<PowerBuffers> power_buffers = std::make_unique<PowerBuffers>();

private:
    template <class T>
    static std::span<std::uint8_t> bytes(T& object) {
        return {reinterpret_cast<std::uint8_t*>(&object), sizeof(T)};
    }
};

}  // namespace sc::stm32h743::cell
