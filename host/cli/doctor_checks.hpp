// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace sc::host::cli {

/// One line of `scribecell doctor`.
struct Check {
    std::string name;
    bool good = false;
    bool needed = false;  ///< ./run cannot do without
    std::string found;    ///< what is there, or what is missing
    std::string action;   ///< what to do when it is not good
};

/// Everything that is looked at. Starts a simulated cell for a moment; opens no device. Never throws.
[[nodiscard]] std::vector<Check> all_checks();

/// Packages of a list (one a line, # begins a comment) that `dpkg_status`, the text of dpkg's status file, does not
/// show as installed.
[[nodiscard]] std::vector<std::string> missing_packages(std::string_view list, std::string_view dpkg_status);

}  // namespace sc::host::cli
