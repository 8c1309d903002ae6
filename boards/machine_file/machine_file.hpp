// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "shared/machine/machine.hpp"

namespace sc::machine_file {

/// The machine of a file (README.md), on top of the reference cell. Throws std::invalid_argument that names file, line,
/// key and what is wrong.
[[nodiscard]] MachineConfig read_machine(const std::filesystem::path& file);
/// The same of a text; `name` stands for the file.
[[nodiscard]] MachineConfig parse_machine(std::string_view text, const std::string& name);

}  // namespace sc::machine_file
