// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

/// One value from several readings of one sensor.

namespace sc::host {

/// `median`: as the paper has it. `mean`: the mean of those readings that lie within four standard deviations of the
/// median; for normal noise its variance is 0.72 of the median's of ten, and a wild reading does not move it.
enum class Estimator : std::uint8_t { median, mean };

struct Location {
    double value = 0.0;
    double sigma = 0.0;        ///< of `value`, for readings of the given sigma
    std::size_t used = 0;      ///< readings that count
    std::size_t left_out = 0;  ///< wild ones; always 0 for the median, which takes all
};

/// `readings` is not empty; `sigma` > 0 is that of one reading. Unit: that of the readings.
[[nodiscard]] Location locate(std::span<const double> readings, double sigma, Estimator estimator);

/// Variance of the median of n normal values of variance 1. Right to 1.5 % from n = 3 on, exact for 1 and 2.
[[nodiscard]] double median_variance(std::size_t n) noexcept;

/// Standard deviation of the readings about their mean; 0 for fewer than two.
[[nodiscard]] double scatter(std::span<const double> readings) noexcept;

/// Whether a sum of squares of `freedom` standard normal values is larger than chance allows one time in a million
/// (Wilson and Hilferty's cube root).
[[nodiscard]] bool beyond_chance(double sum_of_squares, double freedom) noexcept;

}  // namespace sc::host
