// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "host/path/curve.hpp"

namespace sc::host {

/// Replaces runs of at least four straight pieces by arcs between their ends wherever neither the points nor the pieces
/// between them lie further than `allowed` (metres) from the arc. Arcs turn by half a turn at most. What is an arc
/// already stays. Some O(n log n).
[[nodiscard]] std::vector<Piece> fit_arcs(const std::vector<Piece>& pieces, double allowed);

}  // namespace sc::host
