// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "host/formats/stations.hpp"
#include "host/measurement/station.hpp"

namespace sc::host {

struct KnownResidual {
    std::string station;
    double angle_before = 0.0;  ///< measured less known, with the head as it came, rad
    double angle_after = 0.0;
};

struct ReferenceFit {
    TripleRecord head;  ///< with its new covariance
    std::vector<KnownResidual> residuals;
    double angle_sigma_before = 0.0;  ///< of the first station's angle, from the geometry alone, rad
    double angle_sigma_after = 0.0;
    double misfit = 0.0;  ///< rms of the residuals over what is expected of them
};

/// Finds the reference plane in d, and betters the rest of the head, from stations whose pose is known: maximum
/// likelihood, with the head's own covariance as what was known before. Every station of `known` must be in `stations`.
/// Throws InputError (naming `file`): a station that is missing or is refused, a head without any reference to start
/// from, and, with `check`, poses that the head cannot have measured (naming sensors that look exchanged).
[[nodiscard]] ReferenceFit fit_reference(const TripleRecord& head, const StationFile& stations,
                                         const std::vector<KnownPose>& known, const StationOptions& options,
                                         bool check = true);

}  // namespace sc::host
