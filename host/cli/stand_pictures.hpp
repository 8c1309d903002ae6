// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "host/formats/stand.hpp"
#include "host/formats/stations.hpp"
#include "host/measurement/parallelism.hpp"

namespace sc::host::cli {

/// Dots and spots in the pictures of all plates. Throws InputError naming the picture that gives no centre, and why;
/// Interrupted when a person ends it.
[[nodiscard]] std::vector<PlatePixels> pixels_of(const Stand& stand);
/// Readings of all plates; a plate without a file has none.
[[nodiscard]] std::vector<StationFile> readings_of(const Stand& stand);

}  // namespace sc::host::cli
