// SPDX-License-Identifier: Apache-2.0
#include <cstdint>

#include "boards/stm32h743/image/lights.hpp"
#include "boards/stm32h743/registers/access.hpp"
#include "boards/stm32h743/system/clock_start.hpp"
#include "boards/stm32h743/system/fault_record.hpp"
#include "boards/stm32h743/system/interrupts.hpp"
#include "boards/stm32h743/system/watchdogs.hpp"

/// First image for a new board, before any driver: proves clock, memory protection, watchdogs and fault records. Green
/// blinks once a second at 480 MHz; red tells the number of the ClockFault; yellow is on when the last run ended in a
/// fault. What there is to know stands in `report`, for a debugger.

namespace {

using namespace sc::stm32h743;

struct Report {
    std::uint32_t magic = 0x5343'4831;
    ResetCause reset = ResetCause::other;
    ClockFault clock = ClockFault::none;
    bool records = false;
    bool watchdogs = false;
    bool faulted = false;
    std::uint32_t tick = 0;  ///< ms
    FaultRecord fault;
};

Report report;
Watchdogs watchdogs;

constexpr Address kSysTickControl = 0xE000E010;
constexpr Address kSysTickReload = 0xE000E014;
constexpr Address kSysTickValue = 0xE000E018;
constexpr std::uint32_t kCounted = 1U << 16U;
constexpr std::uint32_t kOnByCore = 5;

}  // namespace

extern "C" [[noreturn]] void board_main() {
    make_outputs_safe();
    report.records = start_fault_records();
    report.reset = take_reset_cause();
    if (const auto record = take_fault_record()) {
        report.fault = *record;
        report.faulted = true;
    }
    start_lights();
    const Clocks clocks = start_clocks();
    report.clock = clocks.fault;
    write32(kSysTickReload, clocks.frequencies.core_hz / 1'000 - 1);
    write32(kSysTickValue, 0);
    write32(kSysTickControl, kOnByCore);
    report.watchdogs = watchdogs.start(clocks.frequencies);
    enable_warning();
    while (true) {
        if ((read32(kSysTickControl) & kCounted) == 0) {
            continue;
        }
        ++report.tick;
        note_tick(report.tick);
        const bool fast = clocks.fault == ClockFault::none;
        show({.green = fast && report.tick % 1'000 < 500,
              .yellow = report.faulted,
              .red = !fast && blinks(report.tick, static_cast<std::uint32_t>(clocks.fault))});
        watchdogs.feed(report.records && fast);
    }
}
