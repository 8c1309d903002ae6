// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "shared/drives/drive_plan.hpp"
#include "shared/machine/machine.hpp"

/// The tables [drives.x] to [drives.c] of a machine file: how each drive is spoken to (docs/formats.md). Host only.

namespace sc::host {

/// Node numbers and cycle go into `machine`. Throws InputError with file and line.
[[nodiscard]] DrivePlan read_drive_plan(const std::filesystem::path& file, MachineConfig& machine);

/// Writes the table of one axis, in place of the one that is there, and leaves all else of the file as it is; a file
/// that is missing begins with it. `eds`: the data sheet that it came from, for people. All or nothing.
void write_drive_table(const std::filesystem::path& file, std::size_t axis, std::uint8_t node,
                       const DriveOptions& options, const std::string& eds);

}  // namespace sc::host
