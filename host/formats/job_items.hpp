// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "shared/path/item.hpp"

/// The items of a job as they were sent, for whoever judges afterwards what was burnt (docs/formats.md).

namespace sc::host {

/// Writes the file anew; never leaves half of one. Throws like write_text_file.
void write_job_items(const std::filesystem::path& path, std::span<const Item> items);
/// Throws InputError for a missing file, one of another kind, a cut one (with the byte), and one whose items have
/// another hash than it says.
[[nodiscard]] std::vector<Item> read_job_items(const std::filesystem::path& path);

}  // namespace sc::host
