// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/calibration/board_views.hpp"
#include "host/vision/drawing.hpp"
#include "host/vision/lattice.hpp"

/// Boards from pictures, or from files of measured points, for the commands that calibrate cameras.

namespace sc::host::cli {

struct BoardWords {
    std::string board;    ///< "9x6": columns and rows of inner corners or dots
    double square = 0.0;  ///< pitch, in `unit`
    std::string unit = "mm";
    bool dots = false;          ///< a grid of dots; else a chessboard
    double dot_diameter = 0.0;  ///< in `unit`; 0: perspective is not taken out
    std::string size;           ///< "640x480": of pictures that are not given
};

/// --board, --square, --unit, --dots, --dot-diameter, --size.
void add_board_options(CLI::App& command, BoardWords& words);

struct BoardInput {
    std::vector<BoardView> views;
    std::vector<std::string> notes;  ///< pictures without a board, and why
};

/// `words`: pictures or one CSV (board_points.hpp); patterns with * and ? are expanded. Throws InputError.
[[nodiscard]] std::vector<std::string> expanded(const std::vector<std::string>& words);
[[nodiscard]] BoardInput read_boards(const std::vector<std::string>& files, const BoardWords& words);
/// Gives the pictures of two lists names that pair them: the number at the end of their names where these are unique in
/// both, else their place in the list. Throws InputError for lists of different length that no number pairs.
void pair_names(const std::vector<std::string>& left_files, std::vector<BoardView>& left,
                const std::vector<std::string>& right_files, std::vector<BoardView>& right);

/// Residuals of one picture, 50 times as long as they are.
[[nodiscard]] Drawing residual_drawing(const std::vector<PointFit>& points, std::size_t view, std::size_t camera,
                                       const GridSize& picture);

}  // namespace sc::host::cli
