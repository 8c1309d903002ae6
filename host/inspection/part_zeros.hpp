// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "host/formats/blank_model.hpp"

namespace sc::host {

/// Allowances and tolerances at given places of the part zeros; metres.
struct ZeroEvaluation {
    std::vector<double> allowance;  ///< one a feature: radial of bores, axial of planes
    std::vector<double> distance;   ///< one a tolerance
    double least_radial = 0.0;
    double least_axial = 0.0;
    double least_margin = 0.0;     ///< of all allowances, less what is asked
    double tolerance_error = 0.0;  ///< mean |distance − middle| over half the tolerance's width
};
[[nodiscard]] ZeroEvaluation evaluate_zeros(const BlankModel& model, const std::vector<Vec3>& zeros);

struct ZeroPlacement {
    bool feasible = false;
    std::vector<Vec3> zeros;  ///< metres, in the blank's frame
    ZeroEvaluation at;
    double kkt_residual = 0.0;  ///< of the largest smallest margin, lengths in mm
};
/// The second mode of borrowing: every allowance at least what is asked (hard), every distance as near to the middle of
/// its tolerance as that allows; among those places the largest smallest allowance; among those the least way from
/// where each zero's features lie best by themselves. Bores are cones of the zero's shift and enter as tangent planes
/// until they hold to 1e-9 mm. Some milliseconds.
[[nodiscard]] ZeroPlacement place_zeros(const BlankModel& model);

}  // namespace sc::host
