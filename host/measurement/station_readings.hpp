// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <expected>
#include <string>
#include <vector>

#include "host/measurement/head_model.hpp"
#include "host/measurement/station.hpp"

/// From raw readings to one value a sensor and pose. For the sources of this folder.

namespace sc::host {

struct LocatedStation {
    std::vector<PoseReadings> poses;
    std::size_t used = 0;
    std::size_t left_out = 0;
    double noise = 0.0;
    bool noisier = false;
};

/// Refuses readings that are stale, stuck, faulty, too few, out of range, or of other sensors.
[[nodiscard]] std::expected<LocatedStation, StationRefusal> locate_station(const TripleRecord& head,
                                                                           const Station& station,
                                                                           const StationOptions& options);

}  // namespace sc::host
