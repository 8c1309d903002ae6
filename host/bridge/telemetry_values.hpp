// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "shared/link/telemetry.hpp"

namespace sc::host {

/// One number of a sample.
struct TelemetryValue {
    std::size_t column = 0;   ///< of link::kTelemetryColumns
    std::size_t element = 0;  ///< axis X, Y, Z, C, or sensor of the triple head
    std::int64_t raw = 0;     ///< as on the wire
    /// Places in mm, of C in degrees; else as it is.
    [[nodiscard]] double value() const noexcept;
};

/// nullopt for a sample with channels that are not known, or with values that are not those of its channels.
[[nodiscard]] std::optional<std::vector<TelemetryValue>> decode(const link::Telemetry& sample);
/// "set_point_x_mm", "state", "triple_2_mm" ...
[[nodiscard]] std::string column_name(std::size_t column, std::size_t element);
/// "set_point,state" to bits; `all` is every channel. Throws InputError for a name that is none.
[[nodiscard]] std::uint32_t read_channels(const std::string& names);

}  // namespace sc::host
