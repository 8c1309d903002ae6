// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "shared/machine/machine.hpp"

/// The axis map from measured places, by least squares. Host only (Eigen); some 100 ms for a thousand points.

namespace sc::host {

/// Where the focus truly stood (metres, h) when the axes stood at `reading`.
struct AxesPoint {
    Vec3 reading;
    std::array<int, 3> approach{};  ///< the way each axis last moved: −1, 1; 0 is not known
    Vec3 place;
    int line = 0;  ///< of the file
};
/// Where a target on the table truly stood (metres, h) with C at `c_deg`.
struct TablePoint {
    double c_deg = 0.0;
    int approach = 0;
    int target = 0;
    Vec3 place;
    int line = 0;
};

/// Millimetres and degrees: `x,y,z,true_x,true_y,true_z`, optional `dir_x,dir_y,dir_z` (−1, 0, 1). Throws InputError.
[[nodiscard]] std::vector<AxesPoint> read_axes_points(const std::filesystem::path& file);
/// `c,target,true_x,true_y,true_z`, optional `dir_c`. Throws InputError.
[[nodiscard]] std::vector<TablePoint> read_table_points(const std::filesystem::path& file);

/// How well a fit is supported; metres.
struct FitQuality {
    std::size_t points = 0;
    double before_rms = 0.0;  ///< what the measured places were off without the fit
    double residual_rms = 0.0;
    double residual_max = 0.0;
    double worst_sigma = 0.0;  ///< of a corrected place, anywhere within the travel or the turn
};

/// A corrected place that the data leave less certain than this is refused.
inline constexpr double kLargestMapSigma = 5e-6;

/// Squareness, scale, straightness, pitch and backlash of X, Y and Z: replaces `set.axes` and the linear part of
/// `set.axis_map`. The tables reach over the machine's travel. Backlash is fitted for the axes whose approach is
/// known for every point, from both sides. Throws InputError (`file` for its messages): too few points, an axis
/// approached from one side only, a point further off than six times the rest, places within the travel at which the
/// data say too little (gaps, readings of two axes that always move together).
FitQuality fit_axes(CalibrationSet& set, const MachineConfig& machine, std::span<const AxesPoint> points,
                    const std::filesystem::path& file);
/// Pitch, shift, tilt and backlash of the table about the set's turntable axis: replaces the part of `set.axis_map`
/// over C. The table at C = 0 is the reference: there all corrections are zero. Throws as above.
FitQuality fit_table(CalibrationSet& set, const MachineConfig& machine, std::span<const TablePoint> points,
                     const std::filesystem::path& file);

}  // namespace sc::host
