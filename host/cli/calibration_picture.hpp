// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

#include "host/formats/calibration_set.hpp"

namespace sc::host::cli {

/// The frames as a tree, h at its root: every transform with sigma, age and expiry; below them the records that are no
/// transforms. SVG.
[[nodiscard]] std::string calibration_svg(const CalibrationSet& set, std::chrono::sys_seconds now);

}  // namespace sc::host::cli
