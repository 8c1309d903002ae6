// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/bench/faults/campaign.hpp"

/// What the cell does about each fault in each state, as a table of docs/hazards.md.

namespace sc::faults {

/// Writes the table of these combinations between the page's marks. Throws std::runtime_error if it has none.
void write_reactions(const std::filesystem::path& page, const std::vector<Row>& rows);

/// What the page says otherwise than these combinations have ended; what it says of others is not looked at.
[[nodiscard]] std::vector<std::string> compare_reactions(const std::filesystem::path& page,
                                                         const std::vector<Row>& rows);

}  // namespace sc::faults
