// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/formats/plate.hpp"
#include "shared/machine/machine.hpp"
#include "shared/path/item.hpp"

namespace sc::host {

/// A flat plate before the head, and the crosses to burn into it.
struct PlateOptions {
    Vec3 centre{-0.225, -0.210, -0.250};               ///< of the plate's surface, h
    std::size_t side = 15;                             ///< crosses along each edge of the grid
    double half = 0.0542;                              ///< metres: places in the field from −half to +half
    double arm = 0.7e-3;                               ///< half the length of a stroke
    std::vector<double> depths{-1.5e-3, 0.0, 1.5e-3};  ///< of the surface nearer to the head than the focus
    double shift = 1.5e-3;  ///< each depth's grid is moved on the plate by so much, with the axes
};

struct PlatePlan {
    std::vector<PlateCross> crosses;  ///< in the order in which they are burnt, numbered from 1
    std::vector<Item> items;
    std::uint64_t hash = 0;
    double expected_seconds = 0.0;
};

/// The lines of a grid lie closer towards its edges, where a fit is worst. Two strokes a cross, along x then along z,
/// by the galvo alone; the axes stand still for all crosses of a depth. Throws InputError when machine or galvo do not
/// reach them.
[[nodiscard]] PlatePlan plan_plate(const PlateOptions& options, const MachineConfig& machine);

}  // namespace sc::host
