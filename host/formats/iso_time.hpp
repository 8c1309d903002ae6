// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

/// Times in files: ISO 8601 with a zone, 2026-01-31T12:00:00Z or 2026-01-31T13:00:00.5+01:00.

namespace sc::host {

/// Nothing if it is no such time; fractions of a second are cut off.
[[nodiscard]] std::optional<std::chrono::sys_seconds> parse_iso_time(std::string_view text);
/// In UTC.
[[nodiscard]] std::string iso_time_text(std::chrono::sys_seconds time);
[[nodiscard]] std::chrono::sys_seconds now_in_seconds();

}  // namespace sc::host
