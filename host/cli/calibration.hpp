// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

#include "host/formats/calibration_set.hpp"
#include "host/formats/calibration_store.hpp"

/// The subcommands of `scribecell calibration`, as those of subcommands.hpp.

namespace sc::host::cli {

void add_calibration_store(CLI::App& calibration, int& exit_code);  ///< list, import, rollback
void add_calibration_show(CLI::App& calibration, int& exit_code);
void add_calibration_export(CLI::App& calibration, int& exit_code);
void add_calibration_diff(CLI::App& calibration, int& exit_code);
void add_calibration_budget(CLI::App& calibration, int& exit_code);
void add_calibration_drift(CLI::App& calibration, int& exit_code);

/// "--store DIR", or the default one.
[[nodiscard]] CalibrationStore open_store(const std::string& folder);
/// A set that a person names: a file, "" for the store's current set, else "store:NAME" or just a name in the store
/// where no such file exists. Throws InputError.
[[nodiscard]] CalibrationSet named_set(const std::string& name, const std::string& folder);

}  // namespace sc::host::cli
