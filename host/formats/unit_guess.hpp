// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>

#include "shared/geometry/vec.hpp"
#include "shared/machine/machine.hpp"

namespace sc::host {

/// A unit that numbers said to be millimetres look like instead.
struct UnitGuess {
    std::string_view name;     ///< "metres", "inches"
    double millimetres = 1.0;  ///< of one such unit
};

/// Whether numbers given as millimetres look like another unit. `fits` tells whether a place (metres, in the numbers'
/// own frame) can be reached. The rules, in this order:
///   1. all numbers are within `small_mm` of zero in every coordinate, and they fit when taken as metres (first) or as
///      inches: that unit. In h the zero is a corner of travel far from any workpiece, so real data are never there.
///   2. not one place fits as millimetres, and all fit as metres (first) or as inches: that unit.
/// Nothing otherwise; never a guess from a single coordinate. `small_mm` = 0 switches rule 1 off (frames whose zero
/// may lie in the data). Cost: O(places) calls of `fits`.
[[nodiscard]] std::optional<UnitGuess> guess_unit(std::span<const Vec3> millimetres, double small_mm,
                                                  const std::function<bool(const Vec3&)>& fits);

/// guess_unit for places in h: fits = within the travel of X, Y, Z; small = 1/25.4 of the longest travel.
[[nodiscard]] std::optional<UnitGuess> guess_unit_in_h(std::span<const Vec3> millimetres, const MachineConfig& machine);

}  // namespace sc::host
