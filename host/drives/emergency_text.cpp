// SPDX-License-Identifier: Apache-2.0
#include "host/drives/emergency_text.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>

namespace sc::host {
namespace {

struct Row {
    std::uint16_t code;
    std::string_view text;
};

constexpr std::array kCodes{
    Row{0x0000, "no error, or the error is gone"},
    Row{0x2110, "short circuit or earth leakage at the input"},
    Row{0x2310, "continuous overcurrent of the motor"},
    Row{0x2320, "short circuit or earth leakage of the motor"},
    Row{0x3110, "mains overvoltage"},
    Row{0x3120, "mains undervoltage"},
    Row{0x3130, "a phase of the mains is missing"},
    Row{0x3210, "overvoltage of the link circuit: brake resistor?"},
    Row{0x3220, "undervoltage of the link circuit"},
    Row{0x4210, "the drive is too hot"},
    Row{0x4310, "the drive's power part is too hot"},
    Row{0x5113, "5 V supply too low"},
    Row{0x5114, "24 V supply too low"},
    Row{0x5530, "non-volatile memory"},
    Row{0x6010, "software reset by the watchdog"},
    Row{0x6320, "a parameter is wrong"},
    Row{0x7110, "brake chopper"},
    Row{0x7121, "the motor is blocked"},
    Row{0x7122, "wrong motor, or its commutation is not found"},
    Row{0x7305, "encoder 1"},
    Row{0x7306, "encoder 2"},
    Row{0x7310, "too fast"},
    Row{0x7320, "position"},
    Row{0x7500, "communication"},
    Row{0x8110, "frames were lost: the CAN controller ran over"},
    Row{0x8120, "CAN error passive: cable, terminators, bit rate"},
    Row{0x8130, "heartbeat of the controller missing"},
    Row{0x8140, "came back from bus-off"},
    Row{0x8150, "two nodes have the same identifier"},
    Row{0x8210, "a PDO was too short and was not used"},
    Row{0x8220, "a PDO was too long"},
    Row{0x8240, "SYNC of a length that was not expected"},
    Row{0x8250, "an RPDO did not come in time"},
    Row{0x8311, "torque above its limit"},
    Row{0x8400, "speed control"},
    Row{0x8480, "too fast"},
    Row{0x8600, "positioning"},
    Row{0x8611, "following error: the axis is too far from its target"},
    Row{0x8612, "beyond the reference limit"},
    Row{0x8700, "SYNC missing or irregular"},
    Row{0x9000, "external error input"},
    Row{0xF001, "deceleration"},
    Row{0xFF01, "the maker's own"},
};

constexpr std::array<std::string_view, 16> kGroups{"",
                                                   "some error",
                                                   "current",
                                                   "voltage",
                                                   "temperature",
                                                   "hardware of the drive",
                                                   "software of the drive",
                                                   "additional modules: motor, brake, encoder",
                                                   "monitoring: communication, torque, speed, position",
                                                   "external error",
                                                   "",
                                                   "",
                                                   "",
                                                   "",
                                                   "",
                                                   "additional functions, or the maker's own"};
constexpr std::array<std::string_view, 8> kRegister{"generic",       "current",        "voltage", "temperature",
                                                    "communication", "device profile", "",        "maker's own"};

}  // namespace

std::string emergency_text(std::uint16_t code) {
    std::array<char, 8> number{};
    std::snprintf(number.data(), number.size(), "%04X", code);
    const auto* const row = std::ranges::find(kCodes, code, &Row::code);
    if (row != kCodes.end()) {
        return std::string(number.data()) + ": " + std::string(row->text);
    }
    const std::string_view group = code >> 8U == 0xFF ? "the maker's own" : kGroups.at(code >> 12U);
    return std::string(number.data()) + ": " + (group.empty() ? "not in CiA 301 or 402" : std::string(group)) +
           "; see the drive's manual";
}

std::string error_register_text(std::uint8_t bits) {
    std::string text;
    for (std::size_t i = 0; i < kRegister.size(); ++i) {
        if (((bits >> i) & 1U) != 0 && !kRegister.at(i).empty()) {
            text += (text.empty() ? "" : ", ") + std::string(kRegister.at(i));
        }
    }
    return text;
}

}  // namespace sc::host
