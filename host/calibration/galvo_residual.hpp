// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "host/calibration/galvo_model.hpp"

/// What a galvo's ray model leaves over, as a smoothed grid. Host only; some 10 ms for a thousand samples.

namespace sc::host {

/// Metres: the command, found less modelled, and what it counts for.
struct ResidualSample {
    FieldPlace command{};
    FieldPlace left{};
    double weight = 1.0;
};

/// Fits a bicubic B-spline of side · side coefficients over the square ± half whose curvature costs; generalised
/// cross-validation chooses how much. Sets the model's residual and returns the parameters, of each coordinate, that
/// the grid is worth; 0: what is left is noise, and the model stays as it was.
double fit_residual_grid(GalvoModel& model, const std::vector<ResidualSample>& samples, double half, std::size_t side);

}  // namespace sc::host
