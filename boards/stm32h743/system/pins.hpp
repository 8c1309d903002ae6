// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

/// The wiring table of the NUCLEO-H743ZI2: what is on which pin, and where it comes out on the ST morpho connectors
/// CN11 and CN12 (user manual UM2407, section ST morpho headers). Nothing else of the board says what a pin is for.
/// Not to be used: PA1, PA2, PA7, PB13, PC1, PC4, PC5, PG11, PG13 (Ethernet), PA8 to PA12, PG6, PG7 (USB), PC13 to
/// PC15.

namespace sc::stm32h743 {

enum class Port : std::uint8_t { a, b, c, d, e, f, g, h };

enum class PinUse : std::uint8_t {
    input,        ///< pulled down inside, so that a broken wire reads as the fault
    input_up,     ///< idle high: lines of serial ports
    output,       ///< free to be at any level
    safe_output,  ///< low is safe: a resistor of 4.7 kOhm holds it low outside, and every fault makes it low
    reserved      ///< by the board itself
};

struct Pin {
    const char* signal;
    Port port;
    std::uint8_t number;
    PinUse use;
    std::uint8_t alternate;  ///< function number when a peripheral drives or reads it; kPlain otherwise
    std::uint8_t connector;  ///< 11 or 12; 0: not on a connector
    std::uint8_t place;      ///< on it
};
inline constexpr std::uint8_t kPlain = 255;

inline constexpr std::array kPins{
    // Optics: XY2-100 through a line driver, gate and trigger of the source, power byte with its latch.
    Pin{"galvo clock", Port::e, 2, PinUse::output, kPlain, 11, 46},
    Pin{"galvo sync", Port::e, 3, PinUse::output, kPlain, 11, 47},
    Pin{"galvo x", Port::e, 4, PinUse::output, kPlain, 11, 48},
    Pin{"galvo z", Port::e, 5, PinUse::output, kPlain, 11, 50},
    Pin{"galvo clock for the status line", Port::c, 10, PinUse::input, 6, 11, 1},  // SPI3_SCK, wired to PE2
    Pin{"galvo status", Port::c, 12, PinUse::input, 6, 11, 3},                     // SPI3_MOSI
    Pin{"gate", Port::e, 9, PinUse::safe_output, 1, 12, 52},                       // TIM1_CH1
    Pin{"trigger", Port::e, 13, PinUse::safe_output, 1, 12, 55},                   // TIM1_CH3
    Pin{"break, open is off", Port::e, 15, PinUse::input, 1, 12, 53},              // TIM1_BKIN
    Pin{"power bit 0", Port::f, 0, PinUse::safe_output, kPlain, 11, 53},
    Pin{"power bit 1", Port::f, 1, PinUse::safe_output, kPlain, 11, 51},
    Pin{"power bit 2", Port::f, 2, PinUse::safe_output, kPlain, 11, 52},
    Pin{"power bit 3", Port::f, 3, PinUse::safe_output, kPlain, 12, 58},
    Pin{"power bit 4", Port::f, 4, PinUse::safe_output, kPlain, 12, 38},
    Pin{"power bit 5", Port::f, 5, PinUse::safe_output, kPlain, 12, 36},
    Pin{"power bit 6", Port::f, 6, PinUse::safe_output, kPlain, 11, 9},
    Pin{"power bit 7", Port::f, 7, PinUse::safe_output, kPlain, 11, 11},
    Pin{"power latch", Port::f, 8, PinUse::safe_output, kPlain, 11, 54},
    // Source, shutter and lights.
    Pin{"master oscillator", Port::f, 12, PinUse::safe_output, kPlain, 12, 59},
    Pin{"guide laser", Port::f, 13, PinUse::safe_output, kPlain, 12, 57},
    Pin{"shutter", Port::f, 14, PinUse::safe_output, kPlain, 12, 50},
    Pin{"light red", Port::f, 15, PinUse::output, kPlain, 12, 60},
    Pin{"light yellow", Port::f, 11, PinUse::output, kPlain, 12, 62},
    Pin{"light green", Port::f, 10, PinUse::output, kPlain, 12, 42},
    // Inputs, high is healthy.
    Pin{"e-stop closed", Port::e, 7, PinUse::input, kPlain, 12, 44},
    Pin{"interlock closed", Port::e, 8, PinUse::input, kPlain, 12, 40},
    Pin{"laser ready", Port::d, 10, PinUse::input, kPlain, 12, 65},
    Pin{"laser without alarm", Port::d, 11, PinUse::input, kPlain, 12, 45},
    Pin{"shutter is open", Port::d, 12, PinUse::input, kPlain, 12, 43},
    Pin{"shutter is closed", Port::d, 13, PinUse::input, kPlain, 12, 41},
    Pin{"key at setup", Port::d, 14, PinUse::input, kPlain, 12, 46},
    Pin{"key at production", Port::d, 15, PinUse::input, kPlain, 12, 48},
    Pin{"source pin 11", Port::g, 0, PinUse::input, kPlain, 11, 59},
    Pin{"source pin 12", Port::g, 1, PinUse::input, kPlain, 11, 58},
    Pin{"source pin 16", Port::g, 2, PinUse::input, kPlain, 11, 42},
    Pin{"source pin 21", Port::g, 3, PinUse::input, kPlain, 11, 44},
    // Links: host and drives by CAN, or the host by the serial port of the ST-Link; sensors by RS485; the source.
    Pin{"FDCAN1 receive", Port::d, 0, PinUse::input_up, 9, 11, 57},
    Pin{"FDCAN1 transmit", Port::d, 1, PinUse::output, 9, 11, 55},
    Pin{"FDCAN2 receive", Port::b, 5, PinUse::input_up, 9, 12, 29},
    Pin{"FDCAN2 transmit", Port::b, 6, PinUse::output, 9, 12, 17},
    Pin{"USART3 transmit", Port::d, 8, PinUse::output, 7, 12, 10},
    Pin{"USART3 receive", Port::d, 9, PinUse::input_up, 7, 11, 69},
    Pin{"USART2 driver enable", Port::d, 4, PinUse::output, 7, 11, 39},
    Pin{"USART2 transmit", Port::d, 5, PinUse::output, 7, 11, 41},
    Pin{"USART2 receive", Port::d, 6, PinUse::input_up, 7, 11, 43},
    Pin{"USART6 driver enable", Port::g, 8, PinUse::output, 7, 12, 66},
    Pin{"USART6 transmit", Port::c, 6, PinUse::output, 7, 12, 4},
    Pin{"USART6 receive", Port::c, 7, PinUse::input_up, 7, 12, 19},
    Pin{"UART4 transmit", Port::b, 9, PinUse::output, 8, 12, 5},
    Pin{"UART4 receive", Port::b, 8, PinUse::input_up, 8, 12, 3},
    // Of the board.
    Pin{"LED green", Port::b, 0, PinUse::output, kPlain, 11, 34},
    Pin{"LED yellow", Port::e, 1, PinUse::output, kPlain, 11, 61},
    Pin{"LED red", Port::b, 14, PinUse::output, kPlain, 12, 28},
    Pin{"SWDIO", Port::a, 13, PinUse::reserved, 0, 11, 13},
    Pin{"SWCLK", Port::a, 14, PinUse::reserved, 0, 11, 15},
    Pin{"HSE from the ST-Link", Port::h, 0, PinUse::reserved, kPlain, 11, 29},
};

/// Of a port, one bit a pin.
[[nodiscard]] constexpr std::uint32_t pins_of(Port port, PinUse use) noexcept {
    std::uint32_t mask = 0;
    for (const Pin& pin : kPins) {
        if (pin.port == port && pin.use == use) {
            mask |= 1U << pin.number;
        }
    }
    return mask;
}

/// Whether no two lines of the table have a pin, or a place on a connector, in common.
[[nodiscard]] constexpr bool wiring_is_unique() noexcept {
    for (std::size_t i = 0; i < kPins.size(); ++i) {
        for (std::size_t k = i + 1; k < kPins.size(); ++k) {
            const Pin& a = kPins[i];
            const Pin& b = kPins[k];
            if ((a.port == b.port && a.number == b.number) ||
                (a.connector != 0 && a.connector == b.connector && a.place == b.place)) {
                return false;
            }
        }
    }
    return true;
}
/// Whether every line is one that the chip and the board have.
[[nodiscard]] constexpr bool wiring_is_possible() noexcept {
    constexpr auto kTaken = [](Port port, unsigned n) {
        switch (port) {
            case Port::a: return n == 1 || n == 2 || n == 7 || (n >= 8 && n <= 12);
            case Port::b: return n == 13;
            case Port::c: return n == 1 || n == 4 || n == 5 || n >= 13;
            case Port::g: return n == 6 || n == 7 || n == 11 || n == 13;
            case Port::d:
            case Port::e:
            case Port::f:
            case Port::h: return false;
        }
        return true;
    };
    for (const Pin& pin : kPins) {
        const bool placed =
            pin.connector == 0 || ((pin.connector == 11 || pin.connector == 12) && pin.place >= 1 && pin.place <= 70);
        if (pin.number > 15 || !placed || (pin.alternate > 15 && pin.alternate != kPlain) ||
            kTaken(pin.port, pin.number)) {
            return false;
        }
    }
    return true;
}
static_assert(wiring_is_unique());
static_assert(wiring_is_possible());
static_assert((pins_of(Port::f, PinUse::safe_output) & 0xFFU) == 0xFF, "the power byte is the low byte of port F");

/// Light, or the way for it, comes from these two ports alone.
inline constexpr std::uint32_t kSafeLowE = pins_of(Port::e, PinUse::safe_output);
inline constexpr std::uint32_t kSafeLowF = pins_of(Port::f, PinUse::safe_output);
static_assert(pins_of(Port::a, PinUse::safe_output) == 0 && pins_of(Port::b, PinUse::safe_output) == 0 &&
              pins_of(Port::c, PinUse::safe_output) == 0 && pins_of(Port::d, PinUse::safe_output) == 0 &&
              pins_of(Port::g, PinUse::safe_output) == 0 && pins_of(Port::h, PinUse::safe_output) == 0);

}  // namespace sc::stm32h743
