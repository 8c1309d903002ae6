// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "host/calibration/galvo_model.hpp"
#include "host/formats/calibration_set.hpp"

/// The galvo's model from burnt and measured crosses.

namespace sc::host {

/// How far a head and its lens may be from nominal, 1 σ; in the order of GalvoModel::Parameter.
inline constexpr std::array<double, GalvoModel::kParameters> kGalvoSpread{
    2e-3, 2e-3, 0.05, 0.05, 0.05, 0.05, 0.5e-3, 5e-3, 0.06, 0.06, 3.0, 3.0, 20.0, 0.01, 0.01};

/// One cross: commanded and found. Metres.
struct CrossObservation {
    int number = 0;
    FieldPlace command{};
    FieldPlace landed{};  ///< found place less the place of the axes
    double depth = 0.0;   ///< how much nearer to the head than the focal plane the surface is there
    double sigma = 0.0;   ///< of each coordinate, > 0
};

struct GalvoFitOptions {
    bool residual_grid = true;
    double angle_scale = 0.160;
    double residual_half = 0.060;
    std::size_t residual_side = 10;
};

struct GalvoFit {
    GalvoModel model;
    Covariance<GalvoModel::kParameters> covariance;  ///< of the ray model
    double ray_rms = 0.0;                            ///< metres, of each coordinate, before the residual grid
    double rms = 0.0;                                ///< after it
    double sigma = 0.0;                              ///< metres: noise of a coordinate that the data show
    double field_sigma = 0.0;   ///< metres: largest 1 σ that the ray model's covariance gives a coordinate in the field
    double grid_freedom = 0.0;  ///< parameters that the smoothed grid is worth, of each coordinate; 0: there is none
    std::vector<int> outliers;  ///< numbers of crosses that were not believed
};

/// Robust maximum likelihood: Levenberg-Marquardt with weights after Cauchy and weak priors (the lens and the head are
/// near their nominal figures), then a smoothed residual grid whose stiffness generalised cross-validation chooses. The
/// result depends on the order of the crosses by rounding only.
///
/// Throws std::domain_error with what is missing and what to do, for data that cannot support a fit: fewer than 60
/// crosses; commands that span less than half of ±residual_half in either direction; depths that span less than 0.5 mm;
/// a predicted error in the field of more than 10 µm; a head far from any (places that do not belong to the plan); a
/// noise that is more than five times the stated one and 20 µm.
[[nodiscard]] GalvoFit fit_galvo(const std::vector<CrossObservation>& crosses, const GalvoFitOptions& options = {});

/// The linear record that goes with a model: offset and matrix at the centre of the field, with their covariance.
[[nodiscard]] GalvoRecord linear_record(const GalvoFit& fit);

}  // namespace sc::host
