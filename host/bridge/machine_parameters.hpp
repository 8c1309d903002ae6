// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/machine/machine.hpp"

namespace sc::host {

/// One number of a machine's configuration under a name of its own ("x.speed_mm_s"), in the unit that the name ends in.
struct MachineParameter {
    std::string name;
    std::string text;  ///< what it is, a line
    bool whole = false;
    std::function<double(const MachineConfig&)> get;
    std::function<void(MachineConfig&, double)> set;
};

/// What may be changed of a machine, in the order in which it is shown: travel, limits, windows, times, speeds. Counts,
/// nodes, wiring and sensors are the board's own and are not here.
[[nodiscard]] const std::vector<MachineParameter>& machine_parameters();

/// Null for a name that is none.
[[nodiscard]] const MachineParameter* find_parameter(std::string_view name);

/// Applies "NAME=VALUE". Throws InputError for a name that is none (with the nearest one), for a value that is no
/// number, and for a machine that no controller can run with (link::check).
void set_parameter(MachineConfig& machine, const std::string& setting);

}  // namespace sc::host
