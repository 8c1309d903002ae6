// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/optics/safety_lines.hpp"

#include <initializer_list>

#include "boards/stm32h743/registers/external_lines.hpp"
#include "boards/stm32h743/registers/optics_port.hpp"

namespace sc::stm32h743 {
namespace {

namespace regs = lines_registers;

constexpr std::uint32_t kEstopPin = 7;
constexpr std::uint32_t kInterlockPin = 8;
constexpr std::uint32_t kEstop = 1U << kEstopPin;
constexpr std::uint32_t kInterlock = 1U << kInterlockPin;
constexpr std::uint32_t kBoth = kEstop | kInterlock;
constexpr std::uint32_t kTimerTicks = 240'000'000 / SafetyLines::kGuardHz;

SafetyLines::State without(std::uint32_t open) noexcept { return {(open & kEstop) == 0, (open & kInterlock) == 0}; }

}  // namespace

bool SafetyLines::start() noexcept {
    set_bits(optics_port::kAhb4enr, optics_port::kGpioEClock);
    set_bits(regs::kApb4enr, regs::kSyscfgClock);
    set_bits(optics_port::kApb1lenr, regs::kTim7Clock);
    (void)read32(optics_port::kApb1lenr);  // a clock is there two cycles behind its bit

    opened_ = kBoth;
    clear_bits(regs::kMask, kBoth);
    for (const std::uint32_t pin : {kEstopPin, kInterlockPin}) {
        change_bits(optics_port::kPupdr, 3U << (2U * pin), 2U << (2U * pin));  // down
        change_bits(optics_port::kModer, 3U << (2U * pin), 0);
    }
    change_bits(regs::kPortOf4To7, 15U << 12U, regs::kPortE << 12U);
    change_bits(regs::kPortOf8To11, 15U, regs::kPortE);
    set_bits(regs::kRising, kBoth);
    set_bits(regs::kFalling, kBoth);
    write32(regs::kPending, kBoth);  // what the selection itself has raised
    set_bits(regs::kMask, kBoth);

    write32(regs::kTim7Cr1, 0);
    write32(regs::kTim7Psc, 0);
    write32(regs::kTim7Arr, kTimerTicks - 1);
    write32(regs::kTim7Egr, regs::kGenerateUpdate);
    write32(regs::kTim7Sr, 0);  // before it may interrupt
    write32(regs::kTim7Dier, regs::kUpdateInterrupt);
    write32(regs::kTim7Cr1, regs::kCounterEnable);
    return (read32(regs::kMask) & read32(regs::kRising) & read32(regs::kFalling) & kBoth) == kBoth &&
           (read32(regs::kPortOf4To7) >> 12U & 15U) == regs::kPortE &&
           (read32(regs::kPortOf8To11) & 15U) == regs::kPortE && read32(regs::kTim7Arr) == kTimerTicks - 1;
}

SafetyLines::State SafetyLines::edge() noexcept {
    // Cleared before the level is read: an edge behind the reading interrupts again.
    const std::uint32_t moved = read32(regs::kPending) & kBoth;
    write32(regs::kPending, moved);
    const std::uint32_t open = ~read32(regs::kInputs) & kBoth;
    opened_ |= open | moved;  // a line that moved was open before or is so now
    return without(open | moved);
}

SafetyLines::State SafetyLines::guard_period() noexcept {
    write32(regs::kTim7Sr, ~regs::kUpdateFlag);
    const std::uint32_t open = ~read32(regs::kInputs) & kBoth;
    return without(opened_.exchange(0) | open);
}

}  // namespace sc::stm32h743
