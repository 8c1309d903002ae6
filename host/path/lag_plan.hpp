// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "host/formats/lag_plate.hpp"
#include "shared/machine/machine.hpp"
#include "shared/path/item.hpp"

namespace sc::host {

/// A flat plate before the head, and the lines to burn into it.
struct LagPlateOptions {
    Vec3 centre{-0.225, -0.210, -0.250};  ///< of the plate's surface, h
    double run = 16e-3;                   ///< of each line
    double gap = 1e-3;                    ///< between neighbours
    double pitch = 100e-6;                ///< between marks
};

struct LagPlatePlan {
    LagPlan plan;
    std::vector<Item> items;
    std::uint64_t hash = 0;
    double expected_seconds = 0.0;
};

/// For each mirror, there and back beside each other: straight lines at full and at a quarter of its speed, which show
/// the latency as a shift along the line, and sines at 0.4, 0.6 and 0.8 of its natural frequency at three quarters of
/// its acceleration and jerk, which show damping and frequency by what is left of the swing and by how late it is. The
/// lines lie about the field's centre, those along x above it and those along z below. Throws InputError when they do
/// not fit into the field.
[[nodiscard]] LagPlatePlan plan_lag_plate(const LagPlateOptions& options, const MachineConfig& machine);

}  // namespace sc::host
