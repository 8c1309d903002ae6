// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "host/inspection/inspection.hpp"

namespace sc::host {

/// The pictures of the report as files of their own, SVG: map.svg (the allowance map as it looks at first), sides.svg,
/// histogram_FACE.svg for each face that was seen, datum_ID.svg for each line. Makes the folder. Returns what was
/// written. Throws InputError where a file cannot be written.
std::vector<std::filesystem::path> write_pictures(const std::filesystem::path& folder, const Inspection& inspection,
                                                  const DistanceField& field);

}  // namespace sc::host
