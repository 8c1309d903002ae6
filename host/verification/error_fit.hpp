// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "shared/geometry/vec.hpp"

namespace sc::host {

/// One cross: where it was meant to be and where it was found.
struct ErrorSample {
    Vec3 commanded;  ///< metres
    Vec3 found;
};

/// An error that all crosses share.
struct FoundError {
    std::string_view name;
    double value = 0.0;
    double sigma = 0.0;  ///< standard deviation from the scatter of the crosses
    std::string_view unit;
};

struct ErrorFit {
    std::vector<FoundError> errors;  ///< empty without samples
    double rms_um = 0.0;             ///< of what the errors do not explain, 3-D
    double worst_um = 0.0;
};

/// Least squares for found − commanded as a linear function of the commanded place,
///
///     Δx = offset_x + scale_x·x + (squareness_xz − rotation)·z
///     Δz = offset_z + rotation·x + scale_z·z
///     Δy = offset_y + tilt_yx·x + squareness_yz·z
///
/// with offsets counted at the zero of h, rotation that of the x axis towards +z, squareness_xz as in the calibration
/// set (x per z of an axis that leans). Fewer than four samples, or samples within 10 mm in x or z, show offsets alone.
[[nodiscard]] ErrorFit fit_errors(std::span<const ErrorSample> samples);

}  // namespace sc::host
