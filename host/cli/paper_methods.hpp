// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "host/formats/poses.hpp"
#include "host/registration/chain.hpp"

/// What the measurements' paper does, for benches to compare with: circles through each marker, and views registered
/// each to the one before it.

namespace sc::host::cli {

struct AxisByCircles {
    Vec3 point;
    Vec3 direction;  ///< unit; angles that grow turn counter-clockwise about it
};
/// A circle through each marker's places, and the mean of centres and normals.
[[nodiscard]] AxisByCircles mean_of_circles(const std::vector<MarkerView>& views);

/// Each view is registered to the one before it by the markers that stand still in both, each marker is the mean of its
/// sightings, h_from_c follows from the places pointed at, the axis from circles; each step takes the one before as
/// exact. Places of `asked` in h before the laser. Throws InputError for adjacent views with fewer than three markers
/// in common.
[[nodiscard]] std::vector<ChainPlace> paper_places(const ChainInput& input, const std::vector<ChainPrediction>& asked);

}  // namespace sc::host::cli
