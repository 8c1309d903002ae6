// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/geometry/vec.hpp"

namespace sc::host {

/// A point of a board as a picture shows it, measured by any program.
struct BoardPointRow {
    int line = 0;
    std::string view;
    int column = 0;
    int row = 0;
    std::optional<Vec3> place;  ///< metres, on the board, where the file has it
    double u = 0.0;             ///< px; (0, 0) is the middle of the first pixel
    double v = 0.0;
    double sigma = 0.0;  ///< px; 0: not stated
};

/// CSV with view,row,col,u_px,v_px; X_mm,Y_mm (or X_m, X_inch; X,Y with `unit`) for places on the board, Z likewise;
/// sigma_px. Large and small letters are alike. Throws InputError for all that CsvTable refuses, unknown columns, a
/// unit that is missing or unknown, units mixed, a point that a view has twice, sigma_px below zero.
[[nodiscard]] std::vector<BoardPointRow> read_board_points(const std::filesystem::path& path,
                                                           std::string_view unit = {});

}  // namespace sc::host
