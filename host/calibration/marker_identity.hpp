// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/target.hpp"
#include "shared/geometry/frames.hpp"

/// Which marker of a target is which, by their mutual distances.

namespace sc::host {

struct PlacedMarker {
    Vec3 place;          ///< metres, in c
    double sigma = 0.0;  ///< metres: 1 sigma in the worst direction
};

struct MarkerIdentity {
    std::vector<std::optional<int>> ids;  ///< of each place; none: not of the target
    std::vector<int> missing;             ///< ids of the target that were not seen
    Mat3 rotation;                        ///< c_from_g, from all that were found
    Vec3 translation;                     ///< metres
    double rms = 0.0;                     ///< metres, 3-D
};

struct IdentityOptions {
    double tolerance = 5e-5;  ///< metres, besides five sigma of the place and of the target
    std::size_t fewest = 4;   ///< markers that must fit
};

/// Triples of places are laid upon triples of the target with the same distances; the motion that brings most places
/// onto markers wins. Missing markers and places that are none do no harm. Refused, with the reason, if too few fit,
/// and if another order of the markers fits as many: a layout that looks the same when turned (a regular grid does).
/// Some ms for 30 markers.
[[nodiscard]] std::expected<MarkerIdentity, std::string> identify_markers(const Target& target,
                                                                          const std::vector<PlacedMarker>& places,
                                                                          const IdentityOptions& options = {});

}  // namespace sc::host
