// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/formats/job.hpp"
#include "host/path/beam_reach.hpp"

namespace sc::host {

/// A line on the workpiece, in c.
struct LineToBurn {
    std::string id;
    std::vector<SurfacePlace> places;
    bool closed = false;  ///< the first place is not repeated
    Vec3 normal;          ///< of the plane that it lies in, unit
};
/// A piece of it in the job: path `name` of `face_deg`.
struct BurntPiece {
    std::string name;
    std::string id;  ///< of the line
    ReachedPiece piece;
};
struct NotBurnt {
    std::string id;
    MissedPiece piece;
};
struct LineJob {
    std::vector<JobPath> paths;  ///< in c; faces in the options' order, longest first within a face
    std::vector<BurntPiece> burnt;
    std::vector<NotBurnt> missed;  ///< the longest first
    double burnt_length = 0.0;     ///< metres
    double missed_length = 0.0;
};

/// Splits lines by the faces that reach them and makes the free paths of a job.
[[nodiscard]] LineJob line_job(std::span<const LineToBurn> lines, const BeamReach& reach, const MarkSettings& settings);

}  // namespace sc::host
