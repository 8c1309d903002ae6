// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace sc::host {

/// find_program, or a CellError that says how to come by it.
[[nodiscard]] std::filesystem::path required_program(const std::string& name);

/// Becomes the program, which keeps this one's terminal and signals. Throws std::system_error when that fails.
[[noreturn]] void become_program(const std::filesystem::path& program, const std::vector<std::string>& arguments);

struct ProgramOutput {
    int exit_code = 0;  ///< or 128 + the signal that ended it
    std::string text;   ///< all that it wrote to stdout
};

enum class ProgramErrors : std::uint8_t { shown, dropped };  ///< what becomes of its stderr

/// Runs a program to its end and takes what it writes to stdout; stderr goes where this program's goes. Throws
/// std::system_error when the system refuses. Ctrl-C in the terminal reaches the program too.
[[nodiscard]] ProgramOutput run_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                                        ProgramErrors errors = ProgramErrors::shown);

}  // namespace sc::host
