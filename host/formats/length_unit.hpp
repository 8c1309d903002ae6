// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace sc::host {

/// The unit of the numbers in a file that states none itself.
struct LengthUnit {
    std::string_view name = "mm";
    double metres = 1e-3;  ///< of one such unit
};

/// "um", "mm", "cm", "m", "inch" ("in"), "foot" ("ft"); nothing for any other word.
[[nodiscard]] std::optional<LengthUnit> length_unit(std::string_view name) noexcept;
/// The words above, for messages.
[[nodiscard]] std::string length_unit_names();

}  // namespace sc::host
