// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "host/pendant/port.hpp"

namespace sc::host::cli {

/// Which pendant a person's options name.
struct PendantWords {
    bool used = false;      ///< --pendant
    std::string device{};   ///< --pendant-device
    std::string reports{};  ///< --pendant-reports

    [[nodiscard]] bool asked() const { return used || !device.empty() || !reports.empty(); }
};

/// --pendant, --pendant-device, --pendant-reports.
void add_pendant_options(CLI::App& app, PendantWords& words);
/// Throws InputError.
[[nodiscard]] std::unique_ptr<pendant::PendantPort> open_pendant(const PendantWords& words);

}  // namespace sc::host::cli
