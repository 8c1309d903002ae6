// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/bench/faults/pins.hpp"

/// Says whether a cell has done with a fault as it must, from what is seen of it from outside. It shares nothing with
/// the firmware: its times are those of the design, its states and numbers those of the documents.

namespace sc::faults {

/// What takes the light away first.
enum class Path : std::uint8_t {
    line,   ///< hardware: 1 µs
    guard,  ///< between ticks: 110 µs
    tick,   ///< 1010 µs and the tick
    slow,   ///< a time of its own: what has to be measured, or waited for
    none,   ///< no light has to go
};

struct Verdict {
    std::vector<std::string> violations;
    Path path = Path::none;
    std::optional<double> light_us;    ///< from the fault to the last light
    std::optional<double> trigger_us;  ///< to the last edge that passed the gate
    std::optional<double> gate_us;     ///< to the shut gate
    std::optional<double> tick_us;     ///< to what the tick does by itself
    std::optional<double> rest_ms;     ///< to axes at rest
};

/// Why a fault cannot come in a state and a phase; empty: it can.
[[nodiscard]] std::string cannot_be(std::string_view fault, std::string_view state, std::string_view phase);

/// True if the fault must end in the latched fault there.
[[nodiscard]] bool must_trip(std::string_view fault, std::string_view state);

/// Judges a whole trace, from power-up on; `combination.fault` empty: nothing was done to the cell.
[[nodiscard]] Verdict judge(const Trace& trace, const Combination& combination);

}  // namespace sc::faults
