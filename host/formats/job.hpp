// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/formats/recipe.hpp"
#include "shared/geometry/frames.hpp"

namespace sc::host {

/// Frame in which a job gives places: h at the face's own turntable angle, c, or w (needs the job's alignment).
enum class PlaceFrame : std::uint8_t { h, c, w };
[[nodiscard]] std::string_view name_of(PlaceFrame frame) noexcept;

/// The cross burnt at every point of every face.
struct CrossSettings {
    Length size;  ///< of each of its two strokes (along x, along z)
    MarkSettings settings;
    constexpr bool operator==(const CrossSettings&) const noexcept = default;
};
/// The datum line of each face: on the plane through its points, at constant z through their centroid, centred there,
/// unless the face gives its own ends.
struct DatumLineSettings {
    Length length;
    MarkSettings settings;
    constexpr bool operator==(const DatumLineSettings&) const noexcept = default;
};

/// A datum line whose ends are given.
struct FaceLine {
    int line = 0;  ///< of the job file
    PlaceFrame frame = PlaceFrame::w;
    Vec3 from;  ///< metres
    Vec3 to;
};

/// What the Y sensor is used for while the job is burnt.
struct SurfaceSettings {
    bool follow = false;                       ///< the focus follows the surface; else it is only checked
    Length window;                             ///< the surface may be so far from the focus along y
    Length bound;                              ///< following never shifts y by more
    Speed look_speed = Speed::from_si(0.050);  ///< at which the Y sensor looks at a line before it is burnt
    constexpr bool operator==(const SurfaceSettings&) const noexcept = default;
};
/// Check of the workpiece's seat by the triple head before the job.
struct SeatingSettings {
    std::array<double, 3> expected{};  ///< metres
    Length tolerance;                  ///< each may be so far off
    Length tilt;                       ///< and the three so far apart in how far they are off
    int samples = 10;
    bool operator==(const SeatingSettings&) const noexcept = default;
};

struct JobFace {
    int line = 0;            ///< of the job file
    double angle_deg = 0.0;  ///< face k: the turntable stands at C = −k degrees
    PlaceFrame frame = PlaceFrame::h;
    /// CSV of points (points.hpp) in `frame`; empty: the rows of the job's table with this angle, in h.
    std::filesystem::path points;
    std::optional<FaceLine> datum_line;
};

/// One place of a free path: straight there, or over `via` on a circle. Metres.
struct PathStep {
    int line = 0;  ///< of the file that gives it
    std::optional<Vec3> via;
    Vec3 to;
    bool operator==(const PathStep&) const noexcept = default;
};
/// A free path: neither cross nor datum line.
struct JobPath {
    int line = 0;      ///< of the job file
    std::string name;  ///< unique; "path N" by default, N from 1
    double face_deg = 0.0;
    PlaceFrame frame = PlaceFrame::h;
    std::filesystem::path file;   ///< CSV of places (points.hpp); empty: `steps`
    std::vector<PathStep> steps;  ///< the first is its start
    double arc_fit = 0.0;         ///< share of the tolerance within which dense points may become arcs; 0: they stay
    MarkSettings settings;
};

/// A job: which points on which faces, burnt how. File: format = "scribecell-job", version = 1. Paths are resolved
/// against the job file's folder when read.
struct Job {
    std::filesystem::path file;
    std::string name;
    std::filesystem::path table;                  ///< verification table (table.hpp)
    std::filesystem::path calibration;            ///< calibration set (calibration_set.hpp)
    std::optional<CrossSettings> cross;           ///< none: no crosses
    std::optional<DatumLineSettings> datum_line;  ///< none: no datum lines
    std::optional<SurfaceSettings> surface;       ///< none: the Y sensor is not used
    std::optional<SeatingSettings> seating;       ///< none: the seat is not checked
    std::optional<Rigid<frame::C, frame::W>> c_from_w;
    std::vector<JobFace> faces;  ///< in the order in which they are burnt; angles are unique
    std::vector<JobPath> paths;  ///< a face's come after its crosses and line; faces of paths alone at last
};

/// Throws InputError for a missing file, TOML that does not parse, a missing, unknown or repeated key, a value out of
/// its range, an entry that the recipe does not have, a rotation that is none, `w` without alignment, nothing to burn,
/// the same face twice, a path of fewer than two places. Of the files that the job names only its recipe is opened.
[[nodiscard]] Job read_job(const std::filesystem::path& path);
/// Writes paths relative to the new file's folder. Throws InputError if it cannot be written.
void write_job(const std::filesystem::path& path, const Job& job);

}  // namespace sc::host
