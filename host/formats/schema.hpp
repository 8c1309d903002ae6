// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

/// The schema of the project's SQLite file as a list of migrations. Migration n brings user_version n to n + 1. A
/// released migration is never changed; a new need is a new migration. docs/formats.md describes the tables.

namespace sc::host {

/// SQLite's application_id of our files: "SCRB".
inline constexpr std::int64_t kApplicationId = 0x53435242;

[[nodiscard]] std::span<const std::string_view> schema_migrations() noexcept;

}  // namespace sc::host
