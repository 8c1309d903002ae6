// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "host/formats/recipe.hpp"
#include "host/path/curve.hpp"

/// Lines wider than the spot, so that a person sees them on a casting. A pulse's width is not in it: what is burnt is
/// wider by the spot. Offsets lie across the beam, in h's x and z; the depth stays that of the line. Pure.

namespace sc::host {

/// Why a line cannot be burnt so wide. `line` is that of the piece at fault, 0: the path's own.
struct LineWidthError : std::runtime_error {
    LineWidthError(int line_of_piece, const std::string& problem, std::string value_of, std::string action_to)
        : std::runtime_error(problem), line(line_of_piece), value(std::move(value_of)), action(std::move(action_to)) {}
    int line;
    std::string value;
    std::string action;
};

/// What is burnt in place of a line: a stroke for each element, in this order.
struct Strokes {
    std::vector<std::vector<Piece>> pieces;
    double tolerance = 0.0;  ///< metres: what is left of the settings' for the controller
};

/// The strokes of a line of settings.width: the line itself if that is 0.
///
/// Hatch: parallel strokes, at most settings.fill_step apart and evenly, the outermost `width` apart, there and back in
/// turn; corners are mitred. Wobble: one stroke, the line's place plus a circle of diameter `width`, one turn each
/// fill_step along the line. Arcs become chords, which together with those of the wobble take a tenth of the tolerance
/// (0.1 µm of a tolerance of 0).
///
/// Throws LineWidthError for a hatch of a line along the beam, one whose corner is sharper than 120° (turned by more),
/// and one that a bend is too narrow for, so that a stroke would run back; more than 255 strokes with all passes; a
/// wobble of more than 100 000 points.
[[nodiscard]] Strokes strokes_of(const std::vector<Piece>& line, const MarkSettings& settings);

}  // namespace sc::host
