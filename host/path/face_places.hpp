// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "host/path/job_plan.hpp"

namespace sc::host {

/// A point to be marked, in h with its face before the laser.
struct MarkerPlace {
    int no = 0;
    Point<frame::H> place;
    Source source;
};
struct LineEnds {
    Point<frame::H> from;
    Point<frame::H> to;
    Source source;
};
/// What a face asks for, converted to h.
struct FacePlaces {
    std::vector<MarkerPlace> markers;  ///< in the order of their file
    std::optional<LineEnds> line;      ///< only if the face gives its line's ends
};

/// Reads the face's points file, if it has one, and converts all places: h as they stand; c by h_from_c and the
/// turntable's axis; w by the job's alignment besides. `from_table` as PlanOptions::points_from_table. Throws
/// InputError for a face without points, places that look like inches or metres, an incomplete calibration.
[[nodiscard]] FacePlaces face_places(const Job& job, const JobFace& face, const VerificationTable& table,
                                     const CalibrationSet& calibration, const MachineConfig& machine, bool from_table);

/// A free path's places in h, from the job or from its file; each line is of the path's `file`, or of the job if it has
/// none. Throws InputError as above.
[[nodiscard]] std::vector<PathStep> path_places(const Job& job, const JobPath& path, const CalibrationSet& calibration,
                                                const MachineConfig& machine);

/// Job and table name a face by the same angle, to 1e-6 degree.
[[nodiscard]] bool same_face(double a_deg, double b_deg) noexcept;

}  // namespace sc::host
