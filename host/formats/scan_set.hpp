// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "shared/geometry/frames.hpp"

namespace sc::host {

/// A marker as one view saw it.
struct ScanMarker {
    int id = 0;
    Vec3 place;          ///< metres, in the view's sensor frame
    double sigma = 0.0;  ///< metres, per axis
    bool operator==(const ScanMarker&) const noexcept = default;
};
/// One picture of the 3-D sensor.
struct ScanView {
    int line = 0;  ///< of the file
    std::string id;
    std::optional<Rigid<frame::B, frame::F>> b_from_f;  ///< robot pose; none: not recorded
    double c_deg = 0.0;                                 ///< turntable angle C
    std::vector<ScanMarker> markers;                    ///< ids are unique in a view
    std::filesystem::path cloud;                        ///< empty: markers only
};
/// The views of one scan. File: format = "scribecell-scan-set", version = 1. Robot poses are stored as `b_from_f` or
/// `f_from_b`, named in the file; in memory they are b_from_f. Cloud paths are resolved against the file's folder.
struct ScanSet {
    std::filesystem::path file;
    std::string id;
    std::string time;  ///< ISO 8601 with zone
    std::string note;
    std::vector<ScanView> views;
};

/// Both throw InputError (file, line, value, what to do). The clouds are not opened.
[[nodiscard]] ScanSet read_scan_set(const std::filesystem::path& path);
void write_scan_set(const std::filesystem::path& path, const ScanSet& set);

}  // namespace sc::host
