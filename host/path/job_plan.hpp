// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "host/formats/job.hpp"
#include "host/formats/table.hpp"
#include "host/path/curve.hpp"
#include "shared/machine/machine.hpp"
#include "shared/path/item.hpp"

/// From a job to the items of its stream. All places are converted and checked here, before anything moves; what the
/// machine cannot do is refused with file, line, value and what to do.

namespace sc::host {

enum class PathKind : std::uint8_t { cross_horizontal, cross_vertical, datum_line, free_path };
[[nodiscard]] std::string_view name_of(PathKind kind) noexcept;

/// Where a place in the plan came from.
struct Source {
    std::filesystem::path file;
    int line = 0;  ///< 0 = the file as a whole
    bool operator==(const Source&) const = default;
};

/// One line that will be burnt. Places are in h at the face's turntable angle, before rounding to wire units.
struct PlannedPath {
    std::uint32_t id = 0;   ///< PathBegin::path
    double face_deg = 0.0;  ///< as the job names it; C = −face_deg
    PathKind kind = PathKind::cross_horizontal;
    int marker = 0;          ///< number of the marker; 0 for a datum line or a free path
    Point<frame::H> centre;  ///< of a cross: the measured place; of a datum line: its middle; else of the box around it
    Point<frame::H> from;    ///< in the order in which it is burnt
    Point<frame::H> to;
    MarkSettings settings;
    std::uint8_t pick = 1;  ///< the source runs at pick × (speed / pitch)
    std::size_t first_item = 0;
    std::size_t item_count = 0;  ///< all passes
    Source source;
    std::string name{};                         ///< of a free path
    std::vector<Piece> pieces{};                ///< of a free path; others are straight from `from` to `to`
    std::vector<std::vector<Piece>> strokes{};  ///< of a wide line, in the order of a pass; empty: the pieces
};
/// Of what a path consists, straight or not.
[[nodiscard]] std::vector<Piece> pieces_of(const PlannedPath& path);
/// What a pass burns: each stroke of a wide line, or the pieces.
[[nodiscard]] std::vector<std::vector<Piece>> strokes_of(const PlannedPath& path);

/// A look of the Y sensor among the items, and the path that it is for (an index of JobPlan::paths).
struct PlannedLook {
    std::size_t item = 0;
    std::size_t path = 0;
};

struct JobPlan {
    std::vector<Item> items;
    std::uint64_t hash = 0;  ///< of the items and of nothing else (JobHasher)
    std::vector<PlannedPath> paths;
    std::vector<PlannedLook> looks;
    std::vector<double> faces;  ///< angles as the job names them, in the order in which they are burnt
    std::uint64_t expected_pulses = 0;
    std::uint16_t pulse_width_ns = 0;        ///< that all paths ask for; 0: none does
    double marked_metres = 0.0;              ///< all passes
    double expected_seconds_estimate = 0.0;  ///< of the cell, from the first turn to the last retract
};

struct PlanOptions {
    std::optional<double> face;  ///< only this face of the job
    /// Take every face's points from the verification table (another one than the job's own, say), whatever files the
    /// job names. A face in c or w carries them into its frame and back, so that its chain is still in use.
    bool points_from_table = false;
};

/// Plans a job. For each face in the job's order: Turn, then a cross at every point (the stroke along x and the stroke
/// along z, on the plane through the face's points), nearest first, then the datum line, then its free paths as given.
/// With [surface], and a Y sensor in the calibration, looks come before them (look_plan.hpp).
/// Each stroke of a wide line counts as a pass of its path; a wide datum line is a free path by kind. A pure function
/// but for reading the points files that the job names.
///
/// Throws InputError for: a face filter that the job does not have; a face whose C is out of travel; a face without
/// points or datum line; points or ends that the travel cannot reach with their run-in, or that lie in a keep-out
/// volume; points that look like inches or metres; strokes larger than the galvo's field; speeds above an actuator's
/// limit or below the laser's least marking speed; a pulse rate that no whole multiple brings into the source's range;
/// a pulse energy above what its power gives at that rate; pulse widths that differ; a datum line under 60 mm; an
/// incomplete calibration; a wide cross, and what strokes_of refuses; a galvo path whose depth leaves the window of its
/// fluence tolerance, where the calibration knows the beam; a path that repeats a place, an arc through places on one
/// line or wider than 100 m, arcs with a tolerance under 0.1 µm.
[[nodiscard]] JobPlan plan_job(const Job& job, const VerificationTable& table, const CalibrationSet& calibration,
                               const MachineConfig& machine, const PlanOptions& options = {});

}  // namespace sc::host
