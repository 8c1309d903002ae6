// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "host/formats/poses.hpp"

/// Views of the 3-D sensor brought into one c by markers that stand still round the cell. Alternating least squares:
/// each view onto the map of markers (fit_rigid), each marker into the middle of what the views see, until nothing
/// moves; for noise that is alike everywhere that is the bundle's result.

namespace sc::host {

struct StitchedView {
    Rigid<frame::C, frame::C> c_from_view;
    Covariance<6> covariance;  ///< ξ on the left, of this view alone
    double rms = 0.0;          ///< metres, each coordinate
    std::vector<int> wrong;    ///< ids of markers left out
};
struct Stitch {
    std::map<std::string, StitchedView> views;
    std::map<int, Vec3> references;  ///< metres, c
    double rms = 0.0;                ///< metres, each coordinate, over all views
};

/// c is the frame of the first view. Throws InputError (with `file`) for a view that shares fewer than four markers
/// with those before it, or as fit_rigid does.
[[nodiscard]] Stitch stitch_views(const std::filesystem::path& file, const std::vector<MarkerView>& views);

}  // namespace sc::host
