// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/image/lights.hpp"

#include "boards/stm32h743/registers/fault_registers.hpp"
#include "boards/stm32h743/system/pins.hpp"

namespace sc::stm32h743 {
namespace {

namespace regs = fault_registers;

constexpr Address kGpioB = 0x58020400;
constexpr std::uint32_t kGpioBClock = 1U << 1U;
constexpr std::uint32_t kGreen = 1U << 0U;   // PB0
constexpr std::uint32_t kRed = 1U << 14U;    // PB14
constexpr std::uint32_t kYellow = 1U << 1U;  // PE1
static_assert((pins_of(Port::b, PinUse::output) & (kGreen | kRed)) == (kGreen | kRed));
static_assert((pins_of(Port::e, PinUse::output) & kYellow) == kYellow);

void set(Address port, std::uint32_t pin, bool on) noexcept { write32(port + regs::kBsrr, on ? pin : pin << 16U); }

}  // namespace

void start_lights() noexcept {
    set_bits(regs::kAhb4enr, kGpioBClock | regs::kGpioEClock);
    (void)read32(regs::kAhb4enr);  // the clock is there two cycles later
    show({});
    change_bits(kGpioB + regs::kModer, 3U << 0U | 3U << 28U, 1U << 0U | 1U << 28U);
    change_bits(regs::kGpioE + regs::kModer, 3U << 2U, 1U << 2U);
}

void show(const Lights& lights) noexcept {
    set(kGpioB, kGreen, lights.green);
    set(kGpioB, kRed, lights.red);
    set(regs::kGpioE, kYellow, lights.yellow);
}

}  // namespace sc::stm32h743
