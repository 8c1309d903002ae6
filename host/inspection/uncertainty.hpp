// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "host/inspection/inspection.hpp"

namespace sc::host {

/// What one source adds to the uncertainty of a result.
struct UncertaintySource {
    std::string name;
    double sigma = 0.0;  ///< metres, one standard deviation in any one direction
    std::string from;    ///< what it was computed from
};
struct Uncertainty {
    std::vector<UncertaintySource> allowance;  ///< of the allowance at one scanned place
    std::vector<UncertaintySource>
        lines;  ///< of a place of a datum line: in w, and on the metal where it is calibrated
};

/// Sources that the data themselves tell of: how the points scatter, how firmly they hold the placement, how well the
/// heights of the datum lines are known, and, with a calibration, where it puts the middle of the part in h (its
/// covariance of h_from_c carried to that place). Errors common to the whole scan (its scale, its stitching) are not in
/// the scan and not in here.
[[nodiscard]] Uncertainty uncertainty_of(const Inspection& inspection, const DistanceField& field,
                                         const CalibrationSet* calibration);

/// Two standard deviations of independent sources together (k = 2, some 95 %), metres.
[[nodiscard]] double expanded(std::span<const UncertaintySource> sources);

}  // namespace sc::host
