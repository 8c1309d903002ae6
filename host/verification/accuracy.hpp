// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "host/formats/table.hpp"
#include "host/verification/burn_finder.hpp"
#include "host/verification/error_fit.hpp"
#include "host/verification/world_errors.hpp"

/// Compares what was burnt with the markers' true places, as Table 1 of the RAS3DM paper does: the cross found takes
/// the place of the measurement value. Light marks the surface wherever the focus is, so depth is judged by the focus.

namespace sc::host {

struct PointAccuracy {
    int no = 0;
    Point<frame::H> measured;  ///< from the table
    Point<frame::H> truth;
    Point<frame::H> found;  ///< y: of the focus
    double surface_y = 0.0;
    Vec3 deviation;                     ///< found − truth, metres
    Vec3 csv_deviation;                 ///< measured − truth
    std::optional<Vec3> commanded;      ///< the plan's place for this cross
    std::optional<Vec3> command_error;  ///< found − commanded
    /// Deviation expected from the table and the world's errors; only if the trace's header lists errors.
    std::optional<Vec3> foretold;
    double sigma = 0.0;  ///< of the found place, metres
};

/// Largest magnitude and root mean square per axis, metres.
struct AxisFigures {
    Vec3 max;
    Vec3 rms;
};

struct FaceAccuracy {
    double face_deg = 0.0;
    std::vector<PointAccuracy> points;  ///< in the table's order
    std::vector<int> not_found;         ///< markers of the table without a cross
    std::vector<int> ambiguous;         ///< markers with more than one cross near, or crosses near several; not judged
    std::vector<Point<frame::H>> unmatched;  ///< crosses near no marker
    AxisFigures found;
    AxisFigures csv;  ///< of the same points, from the table alone
    /// Of the same points, table plus the world's listed errors; none if the trace's header lists no error.
    std::optional<AxisFigures> foretold;
    std::optional<double> difference;  ///< largest |found − foretold| of max and rms over the axes, metres
};

/// A datum line as found, against plan and markers.
struct LineAccuracy {
    FoundLine found;
    std::optional<double> command_error;  ///< largest distance of its ends from the planned line (x, z, focus), metres
    double plane_distance = 0.0;          ///< largest |focus y − plane through the face's measured places| at its ends
};

struct AccuracyReport {
    std::vector<FaceAccuracy> faces;  ///< those of the plan
    std::vector<LineAccuracy> lines;
    ErrorFit common;                    ///< errors that all crosses share
    std::vector<ErrorBalance> known;    ///< what the trace's header lists
    double max_command_error = 0.0;     ///< largest 3-D distance of a cross from its command, metres
    Vec3 max_command_error_axes;        ///< largest per axis
    std::size_t lines_missing = 0;      ///< faces whose planned datum line was not found
    std::size_t lines_extra = 0;        ///< found where none was planned
    std::size_t crosses_elsewhere = 0;  ///< found on faces that the plan has not
    bool complete = false;              ///< every planned cross and line was found once, and nothing else
};

/// `match_radius`: a cross belongs to the marker whose true place is within it (x, z). Pure.
[[nodiscard]] AccuracyReport assess(const BurnFindings& found, const VerificationTable& table, const JobPlan& plan,
                                    const TraceHeader& header, const CalibrationSet& calibration,
                                    double match_radius = 2e-3);

/// Angles of all faces of a table, each once, in the table's order: what find_burns asks for.
[[nodiscard]] std::vector<double> face_angles(const VerificationTable& table);

}  // namespace sc::host
