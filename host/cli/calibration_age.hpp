// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

#include "host/formats/calibration_set.hpp"

namespace sc::host::cli {

/// "3 days", "5 hours", "12 minutes": to one unit, at least "1 minute". `span` is taken without its sign.
[[nodiscard]] std::string span_text(std::chrono::seconds span);

/// Before a set is worked with: throws InputError that names the records that have expired; with `accept` it warns on
/// stderr. Warns as well of records that expire within a day.
void check_age(const CalibrationSet& set, bool accept);

}  // namespace sc::host::cli
