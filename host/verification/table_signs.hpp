// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "host/verification/table_check.hpp"

/// The tests behind the warnings of table_check.hpp.

namespace sc::host {

/// Probability that the mean of so many values of this rms is as near to zero as `mean`, or nearer, had nothing been
/// taken out: normal, with the scatter about the mean as sigma. Rounding to `digit` alone is allowed for. 1 for fewer
/// than three values or values without scatter.
[[nodiscard]] double mean_chance(double mean, double rms, std::size_t count, double digit) noexcept;

/// Of several such probabilities as small together, by Fisher's method: −2 Σ ln p is chi-squared.
[[nodiscard]] double joint_chance(const std::vector<double>& chances) noexcept;

/// Fills `grids`, `zeroed_chance` and `warnings`; the figures must be there.
void find_signs(const PrintedTable& table, const std::vector<PrintedMaximum>& maxima, TableAssessment& assessment);

}  // namespace sc::host
