// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/io/digital_port.hpp"

#include "boards/stm32h743/registers/gpio.hpp"

namespace sc::stm32h743 {
namespace {

constexpr Address kIn = gpio::base(gpio::Port::d);
constexpr Address kSource = gpio::base(gpio::Port::g);
constexpr Address kOut = gpio::base(gpio::Port::f);
constexpr unsigned kInFirst = 10;
constexpr std::uint32_t kInPins = 0x3FU << kInFirst;
constexpr std::uint32_t kSourcePins = 0xF;
constexpr std::uint32_t kOutFirst = 10;
constexpr std::uint32_t kOutPins = 0x3FU << kOutFirst;

/// `value` in the two bits of each of `pins`.
constexpr std::uint32_t pairs(std::uint32_t pins, std::uint32_t value) {
    std::uint32_t all = 0;
    for (std::uint32_t pin = 0; pin < 16; ++pin) {
        all |= ((pins >> pin) & 1U) != 0 ? value << (2 * pin) : 0;
    }
    return all;
}

void make_inputs(Address port, std::uint32_t pins) noexcept {
    change_bits(port + gpio::kPupdr, pairs(pins, 3), pairs(pins, gpio::kPullDown));
    change_bits(port + gpio::kModer, pairs(pins, 3), pairs(pins, gpio::kInput));
}

constexpr bool has(std::uint32_t levels, unsigned pin) { return ((levels >> pin) & 1U) != 0; }
constexpr std::uint32_t bit_if(bool on, unsigned pin) { return on ? 1U << pin : 0U; }

}  // namespace

bool DigitalPort::start() noexcept {
    set_bits(gpio::kAhb4enr, gpio::clock(gpio::Port::d) | gpio::clock(gpio::Port::f) | gpio::clock(gpio::Port::g));
    (void)read32(gpio::kAhb4enr);  // a clock is there two cycles behind its bit
    make_safe();
    clear_bits(kOut + gpio::kOtyper, kOutPins);
    change_bits(kOut + gpio::kModer, pairs(kOutPins, 3), pairs(kOutPins, gpio::kOutput));
    make_inputs(kIn, kInPins);
    make_inputs(kSource, kSourcePins);
    return (read32(kOut + gpio::kModer) & pairs(kOutPins, 3)) == pairs(kOutPins, gpio::kOutput) &&
           (read32(kIn + gpio::kPupdr) & pairs(kInPins, 3)) == pairs(kInPins, gpio::kPullDown) &&
           (read32(kSource + gpio::kPupdr) & pairs(kSourcePins, 3)) == pairs(kSourcePins, gpio::kPullDown);
}

void DigitalPort::sample(DigitalInputs& in) noexcept {
    const std::uint32_t levels = read32(kIn + gpio::kIdr);
    in.laser_ready = has(levels, kInFirst);
    in.laser_no_alarm = has(levels, kInFirst + 1);
    in.shutter_open = has(levels, kInFirst + 2);
    in.shutter_closed = has(levels, kInFirst + 3);
    in.key_setup = has(levels, kInFirst + 4);
    in.key_production = has(levels, kInFirst + 5);
    in.source_status = static_cast<std::uint8_t>(read32(kSource + gpio::kIdr) & kSourcePins);
}

void DigitalPort::write(const DigitalOutputs& out) noexcept {
    const std::uint32_t on = bit_if(out.light_green, kOutFirst) | bit_if(out.light_yellow, kOutFirst + 1) |
                             bit_if(out.master_oscillator, kOutFirst + 2) | bit_if(out.guide_laser, kOutFirst + 3) |
                             bit_if(out.shutter_open, kOutFirst + 4) | bit_if(out.light_red, kOutFirst + 5);
    write32(kOut + gpio::kBsrr, on | (kOutPins & ~on) << 16U);
}

}  // namespace sc::stm32h743
