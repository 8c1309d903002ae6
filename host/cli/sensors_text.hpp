// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "shared/link/messages.hpp"

namespace sc::host::cli {

/// Names of the four sensors, in the order of the report.
inline constexpr std::array<std::string_view, 4> kSensorNames{"y", "triple 1", "triple 2", "triple 3"};

/// "good", "repeated", "stale", "out of range", "faulty", "none", "not fitted".
[[nodiscard]] std::string_view quality_name(const link::SensorReport& report, std::size_t sensor);
/// Code and text of what a sensor lacks, empty when it is well.
[[nodiscard]] std::string trouble_text(const link::SensorReport& report, std::size_t sensor);
/// A line for each sensor and one for what they are used for.
[[nodiscard]] std::string sensors_text(const link::SensorReport& report);
[[nodiscard]] nlohmann::ordered_json sensors_json(const link::SensorReport& report);

}  // namespace sc::host::cli
