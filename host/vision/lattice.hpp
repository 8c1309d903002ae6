// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

/// Points of a picture as crossings of a bent, slanted grid.

namespace sc::host {

struct GridSize {
    int columns = 0;
    int rows = 0;
};

struct GridPoint {
    int column = 0;
    int row = 0;
    std::size_t index = 0;  ///< of the points given
};

/// The block of `size` among the points: grown from one point to its neighbours, each looked for where the grid so far
/// says. The rows run on the left of the columns' direction as seen in the picture (x right, y down: to the right of
/// it), so the grid is not mirrored; which of its corners is the first is arbitrary. Up to a fifth of the points may be
/// missing, but of no outer row all. None if there is no such block, or more than one.
[[nodiscard]] std::optional<std::vector<GridPoint>> find_grid(std::span<const std::array<double, 2>> points,
                                                              const GridSize& size);

/// The same grid begun at the opposite corner, and for a square one at the next corner.
[[nodiscard]] std::vector<GridPoint> turned_half(const std::vector<GridPoint>& grid, const GridSize& size);
[[nodiscard]] std::vector<GridPoint> turned_quarter(const std::vector<GridPoint>& grid, const GridSize& size);
/// How far to the right the columns run: cosine.
[[nodiscard]] double heading_right(const std::vector<GridPoint>& grid, std::span<const std::array<double, 2>> points);

}  // namespace sc::host
