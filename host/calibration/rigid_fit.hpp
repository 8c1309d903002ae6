// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "host/formats/poses.hpp"

/// The rigid transform between two frames from markers that were measured in both, each with noise of its own along
/// each axis (a beam is pointed less well across than along). Maximum likelihood: the true places are unknown too, so a
/// residual b − (R a + t) counts by the inverse of Σ_b + R Σ_a Rᵀ. Host only; well below a millisecond.

namespace sc::host {

struct RigidOptions {
    double sigma = 7.5e-6;      ///< metres, of a coordinate that states none
    bool find_wrong = true;     ///< leave out, and name, markers that fit no noise
    double most_turn = 8.7e-3;  ///< radians: more uncertainty than that is refused
    double most_place = 5e-3;   ///< metres, at the middle of the markers
};
struct RigidMarker {
    int id = 0;
    bool used = true;
    Vec3 residual;          ///< metres, in the frame fitted to
    double surprise = 0.0;  ///< chi-squared of that, 3 degrees of freedom
};
struct RigidFit {
    Mat3 rotation;  ///< to_from_from
    Vec3 translation;
    Covariance<6> covariance;  ///< as in TransformRecord
    std::vector<RigidMarker> markers;
    double rms = 0.0;  ///< metres, each coordinate, of the markers used
    double chi_squared = 0.0;
    double freedom = 0.0;
    double raised = 1.0;  ///< factor by which the sigmas were raised since the data scatter more than stated
};

/// Pairs by id; an id of one cloud alone counts for nothing. Throws InputError (with `file`) for fewer than three
/// common markers, markers on a line (the blind direction is named), and clouds of which most markers do not match.
[[nodiscard]] RigidFit fit_rigid(const std::filesystem::path& file, const std::vector<SeenMarker>& to,
                                 const std::vector<SeenMarker>& from, const RigidOptions& options = {});

}  // namespace sc::host
