// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "shared/drives/drive_plan.hpp"
#include "shared/machine/machine.hpp"

namespace sc::drive_file {

/// What a machine file says of its drives.
struct DriveFile {
    DrivePlan plan;
    std::array<std::string, kAxisCount> quirks{};  ///< of simulated drives (boards/sim/plant/drive_quirks)
};

/// Reads the tables [drives.*]; node numbers, cycle and homing places go into `machine`. Throws std::invalid_argument
/// "FILE:LINE: ..." for a file that cannot be read, a key that is none and a value out of its range.
[[nodiscard]] DriveFile read_drive_file(const std::filesystem::path& file, MachineConfig& machine);

/// The bus budget, one line a term, for people: what does not fit is to be refused with it.
[[nodiscard]] std::string budget_text(const MachineConfig& machine, const DrivePlan& plan);

}  // namespace sc::drive_file
