// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
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

/// The axes stand here while the galvo burns crosses at these places of the field (x, z; metres from the axes).
struct PlateStand {
    Vec3 anchor;
    std::vector<std::array<double, 2>> places;
};
/// Two strokes a cross, of twice `arm`, along x then along z, by the galvo alone. Throws InputError when machine or
/// galvo do not reach them.
[[nodiscard]] PlatePlan plan_stands(const std::vector<PlateStand>& stands, double arm, const MachineConfig& machine);

/// A face of a stepped block before the head: where its rectangle lies in h, to a millimetre.
struct StepFace {
    int step = 0;
    std::array<double, 2> x{};  ///< metres, from and to
    std::array<double, 2> z{};
    double y = 0.0;
};
/// Crosses on each face of a stepped block: on each, the axes stand left and right of its middle, at each depth, so
/// that stage, galvo and depth all vary. `across` × `up` crosses a stand, `edge` metres from the face's edges.
struct StepPlateOptions {
    std::vector<StepFace> faces;
    std::size_t across = 5;
    std::size_t up = 9;
    double edge = 0.012;
    double half = 0.0542;
    double arm = 0.7e-3;
    std::vector<double> depths{-1.5e-3, 0.0, 1.5e-3};
};
/// Throws as plan_stands, and for a face that is too small.
[[nodiscard]] PlatePlan plan_step_plate(const StepPlateOptions& options, const MachineConfig& machine);

/// The lines of a grid lie closer towards its edges, where a fit is worst. Two strokes a cross, along x then along z,
/// by the galvo alone; the axes stand still for all crosses of a depth. Throws InputError when machine or galvo do not
/// reach them.
[[nodiscard]] PlatePlan plan_plate(const PlateOptions& options, const MachineConfig& machine);

}  // namespace sc::host
