// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/calibration/turntable_fit.hpp"
#include "host/formats/calibration_set.hpp"

/// The steps of `scribecell calibrate all` that are no commands of their own.

namespace sc::host::cli {

/// Runs scribecell-survey; throws CellError when it fails.
void survey(const std::vector<std::string>& words);

struct Stitch {
    std::map<std::string, Rigid<frame::C, frame::C>> views;  ///< c_from_view
    double rms = 0.0;                                        ///< metres, each coordinate of the references
    std::vector<std::string> left_out{};                     ///< why, of views that have no place

    /// Throws InputError for a view that has none.
    [[nodiscard]] const Rigid<frame::C, frame::C>& of(const std::string& view) const;
};
/// Every view's place in c: by the reference markers of the folders (references.csv in each), the first folder's first
/// view being c. Views are named "folder/view".
[[nodiscard]] Stitch stitch_folders(const std::vector<std::filesystem::path>& folders);
/// The same by robot.csv and where the sensor sits on the flange.
[[nodiscard]] Stitch stitch_by_robot(const std::vector<std::filesystem::path>& folders,
                                     const Rigid<frame::F, frame::C>& f_from_c);

/// Markers of a folder's markers.csv, brought into c.
[[nodiscard]] std::vector<MarkerView> markers_in_c(const std::filesystem::path& folder, const Stitch& stitch);

/// The axis as a record in h: what the fit in c is uncertain of, and what h_from_c is.
[[nodiscard]] AxisRecord axis_record(const TurntableFit& fit, const CalibrationSet& set);

/// A face's marker, tied to the table at C = 0.
struct FaceMarker {
    double face_deg = 0.0;
    int no = 0;
    Vec3 place;  ///< metres, c
};
/// Writes face*.csv (points in c), measured.csv (in h, each at its face) and job.toml. `table` is named in the job.
void write_marker_job(const CalibrationSet& set, const std::filesystem::path& calibration,
                      const std::vector<FaceMarker>& markers, const std::filesystem::path& folder);

}  // namespace sc::host::cli
