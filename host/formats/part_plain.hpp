// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "host/formats/part.hpp"

/// Machining descriptions as people write them beside a CAD file: `units` for all numbers instead of `format` and a
/// unit in every key. For the sources of this folder only.

namespace sc::host {

/// True for a text that has a key `units` and no `format`. Throws InputError if it is no TOML.
[[nodiscard]] bool is_plain_part(const std::filesystem::path& path, std::string_view text);
[[nodiscard]] Part parse_plain_part(const std::filesystem::path& path, std::string_view text);

}  // namespace sc::host
