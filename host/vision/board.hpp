// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <expected>
#include <string>
#include <vector>

#include "host/vision/drawing.hpp"
#include "host/vision/grey_image.hpp"
#include "host/vision/lattice.hpp"

/// Boards in pictures: inner corners of a chessboard, dots of a grid.

namespace sc::host {

struct BoardCorner {
    int column = 0;
    int row = 0;
    double x = 0.0;  ///< px; (0, 0) is the middle of the first pixel. Of a dot: the middle of its ellipse
    double y = 0.0;
    double sigma = 0.0;  ///< px; 0: not known
};

struct BoardFound {
    std::vector<BoardCorner> corners;  ///< by rows; columns and rows are not mirrored as seen (x right, y down)
    bool first_is_sure = true;         ///< which corner is the first follows from the board, not from the view
};

/// Inner corners of a chessboard, `size` of them, each way two or more. The first corner lies between dark squares of
/// the diagonal away from it; a board that looks the same from the other end begins where its columns run to the right.
/// Corners are saddles of the light that a ring of 16 pixels around confirms; each is then moved to where the gradients
/// around it point past it: to 0.1 px on sharp pictures. Refused, with the reason, where there is no such board.
[[nodiscard]] std::expected<BoardFound, std::string> find_chessboard(const GreyImage& image, const GridSize& size);

/// Dots of a grid, by find_markers. A dot half as large again as the others is at the first corner; without one the
/// columns run to the right.
[[nodiscard]] std::expected<BoardFound, std::string> find_dot_grid(const GreyImage& image, const GridSize& size);

/// The corners, joined in their order; the first is drawn large.
[[nodiscard]] Drawing overlay_of(const GreyImage& image, const BoardFound& found);

}  // namespace sc::host
