// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/table.hpp"

/// What a verification table really says: its figures recomputed from its digits, and signs that it was not made as it
/// should be. Deviation is measured − true throughout, in metres. Pure; works on the table alone and shares nothing
/// with what made it. Host only; milliseconds.

namespace sc::host {

/// Largest (with its sign), rms and mean of the deviations, each axis, and of their length.
struct DeviationFigures {
    std::size_t points = 0;
    Vec3 largest;
    std::array<int, 3> largest_no{};  ///< the markers that show them
    Vec3 rms;
    Vec3 mean;
    double rms_3d = 0.0;
    double max_3d = 0.0;
    int max_3d_no = 0;
};

/// deviation = offset + along_first·a + along_second·b over the two other coordinates, by least squares.
struct PlaneOfColumn {
    double offset = 0.0;
    std::array<double, 2> slope{};
    double rms = 0.0;  ///< of what it leaves over
};

struct TableFace {
    double face_deg = 0.0;
    DeviationFigures figures;
    DeviationFigures after_fit;            ///< after the rigid motion that fits this face best
    Vec3 mean_chance;                      ///< probability that a mean is this near to zero, given the scatter
    std::array<PlaneOfColumn, 3> plane{};  ///< of x over y, z; of y over x, z; of z over x, y
};

/// What one motion for the whole table leaves over.
struct GlobalFit {
    double rms_3d = 0.0;
    double max_3d = 0.0;
    double removed = 0.0;  ///< share of the sum of squares that it takes away
};

/// The values of one column stand on a grid of its own offset on each face.
struct JogGrid {
    char axis = 'x';
    bool of_truth = false;   ///< of the true values themselves, not of the deviations
    double step = 0.0;       ///< metres
    std::size_t within = 0;  ///< values within the last digit of the grid
    std::size_t values = 0;
    double log10_chance = 0.0;  ///< of as many by chance, with the search for step and offset counted
};

enum class TableFinding : std::uint8_t {
    arithmetic,        ///< printed deviations are not m − t
    reversed,          ///< printed deviations are t − m
    printed_maximum,   ///< a printed largest value that the points do not have
    zeroed_mean,       ///< a shift was taken out of each face
    jog_grid,          ///< the true values come in steps
    dependent_column,  ///< one coordinate follows from the others
    copied_column,     ///< true equals measured throughout
    few_points,        ///< too few on a face for a fit of its own
};
[[nodiscard]] std::string_view name_of(TableFinding finding) noexcept;

struct TableWarning {
    TableFinding finding;
    std::string text;        ///< one line for a person
    std::vector<int> lines;  ///< of the file; may be empty
};

struct TableAssessment {
    std::vector<TableFace> faces;  ///< in the order of the table
    DeviationFigures all;
    double digit = 0.0;               ///< metres: the last digit that the table prints
    double pooled_3d = 0.0;           ///< rms after each face's own rigid fit
    double removed_by_faces = 0.0;    ///< share of the sum of squares that those fits take away
    double in_plane_sigma = 0.0;      ///< metres: of x and z after those fits, each coordinate
    double in_plane_95 = 0.0;         ///< metres: 95 % of |x| and |z| as they stand are below
    std::optional<GlobalFit> rigid;   ///< none for fewer than three points
    std::optional<GlobalFit> affine;  ///< none for fewer than five points
    std::vector<JogGrid> grids;
    Vec3 zeroed_chance{1.0, 1.0, 1.0};  ///< that all faces' means are this near to zero by chance, each axis
    std::vector<TableWarning> warnings;
};

/// A largest deviation that somebody has printed for a face; its sign is not compared.
struct PrintedMaximum {
    int line = 0;
    double face_deg = 0.0;
    std::array<std::optional<double>, 3> axis;  ///< metres
    std::optional<double> any;                  ///< metres: largest of all axes
};

[[nodiscard]] TableAssessment assess_table(const PrintedTable& table, const std::vector<PrintedMaximum>& maxima = {});

/// A panel a face, seen from the laser: deviations in x and z as arrows, 500 times enlarged, y as a bar beside it.
[[nodiscard]] std::string table_svg(const VerificationTable& table, const TableAssessment& assessment);

}  // namespace sc::host
