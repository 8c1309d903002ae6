// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/machine_keys.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "shared/link/config.hpp"

namespace sc::sim {
namespace {

constexpr double kRingRadius = 0.25;  ///< m

[[noreturn]] void refuse(const std::string& setting, const std::string& why) {
    throw std::invalid_argument("--machine " + setting + ": " + why +
                                "; give KEY=VALUE with a key of galvo.word (16 or 18), galvo.latency_us, "
                                "galvo.natural_frequency_hz (0: unknown), galvo.damping, galvo.follow (off, drives or "
                                "encoders), axis.encoder_um "
                                "(0: none), laser.power_byte (average or "
                                "energy)");
}

double number(const std::string& setting, std::string_view text) {
    double value = 0.0;
    const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
    if (end.ec != std::errc() || end.ptr != text.data() + text.size() || !(value >= 0.0 && value <= 1e6)) {
        refuse(setting, "the value is no number of 0 to 1000000");
    }
    return value;
}

void set_one(MachineConfig& machine, const std::string& setting) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos) {
        refuse(setting, "no '='");
    }
    const std::string_view key = std::string_view(setting).substr(0, equals);
    const std::string_view value = std::string_view(setting).substr(equals + 1);
    if (key == "galvo.word" && (value == "16" || value == "18")) {
        machine.galvo.word = value == "18" ? GalvoWord::bits18 : GalvoWord::bits16;
    } else if (key == "galvo.latency_us") {
        machine.galvo.latency_ns = std::llround(number(setting, value) * 1e3);
    } else if (key == "galvo.natural_frequency_hz") {
        machine.galvo.natural_frequency = Frequency::from_si(number(setting, value));
    } else if (key == "galvo.damping") {
        machine.galvo.damping = number(setting, value);
    } else if (key == "galvo.follow" && (value == "off" || value == "drives" || value == "encoders")) {
        machine.galvo.follow = value == "off"      ? FollowAxes::off
                               : value == "drives" ? FollowAxes::drives
                                                   : FollowAxes::encoders;
    } else if (key == "axis.encoder_um") {
        // A ring on the turntable's rim, 0.25 m from its axis, has the same line.
        const double grid = number(setting, value) * 1e-6;
        for (AxisConfig& axis : machine.axis) {
            axis.encoder_counts_per_unit = grid > 0.0 ? 1.0 / grid : 0.0;
        }
        machine.axis[index(Axis::c)].encoder_counts_per_unit *= kRingRadius * kPi / 180.0;
    } else if (key == "laser.power_byte" && (value == "average" || value == "energy")) {
        machine.laser.power_byte = value == "energy" ? PowerByte::pulse_energy : PowerByte::average_power;
    } else {
        refuse(setting, "not known");
    }
}

}  // namespace

void set_machine(MachineConfig& machine, const std::vector<std::string>& settings) {
    for (const std::string& setting : settings) {
        set_one(machine, setting);
    }
    if (!settings.empty() && link::check(machine) != Refusal::none) {
        refuse(settings.back(),
               "no controller can run with this machine (is the galvo's latency below its servo's lag?)");
    }
}

}  // namespace sc::sim
