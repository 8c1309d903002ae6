// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/geometry/vec.hpp"

namespace sc::host {

/// An order in which neighbours in the list are neighbours in space (Morton's curve; equal cells keep their order).
/// Some 12 ns a place and thread. At most 2^32 places.
[[nodiscard]] std::vector<std::uint32_t> space_order(std::span<const Vec3> places, unsigned threads);

}  // namespace sc::host
