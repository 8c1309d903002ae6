// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "host/bridge/client.hpp"

namespace sc::host::cli {

/// Before a fault is acknowledged, after which the cell writes over what it holds: reads the black box into
/// blackbox-TIME.csv in `folder` (that of the present one if empty). Returns what to tell a person; a cell that tells
/// nothing is no reason to stop. Throws Interrupted.
[[nodiscard]] std::string keep_black_box(CellClient& client, const std::filesystem::path& folder);

}  // namespace sc::host::cli
