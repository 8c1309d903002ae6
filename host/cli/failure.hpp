// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include <nlohmann/json_fwd.hpp>

namespace sc::host::cli {

/// Why a subcommand ends early, for a person and for a program.
struct Failure {
    int exit_code = 0;
    std::uint16_t code = 0;  ///< of shared/codes; 0 = none of them
    std::string name;        ///< of the code, or "bad_input", "link", "interrupted", "failed"
    std::string message;     ///< one line for a person
    std::string action;      ///< what to do; may be empty
    std::string file;        ///< bad input only
    int line = 0;            ///< bad input only; 0 = the file as a whole
    std::string value;       ///< bad input only
};

/// From the exception being handled; call in a catch block.
[[nodiscard]] Failure current_failure();
/// {"code","name","text","action"} and, for bad input, "file","line","value".
[[nodiscard]] nlohmann::ordered_json to_json(const Failure& failure);
/// Prints the failure on stderr.
void print_failure(const Failure& failure);
/// Runs a subcommand. What it throws is printed on stderr (and with `json` as {"error":…} on stdout); returns the exit
/// code.
[[nodiscard]] int guarded(bool json, const std::function<int()>& work);

}  // namespace sc::host::cli
