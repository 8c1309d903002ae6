// SPDX-License-Identifier: Apache-2.0
#include "host/measurement/location.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace sc::host {

namespace {

constexpr double kWild = 4.0;             ///< standard deviations from the median; white noise: one reading in 16 000
constexpr double kOneInAMillion = 4.753;  ///< of the standard normal distribution, one side

double median_of(std::span<const double> readings) {
    std::vector<double> sorted(readings.begin(), readings.end());
    std::sort(sorted.begin(), sorted.end());
    const std::size_t half = sorted.size() / 2;
    return sorted.size() % 2 == 1 ? sorted[half] : 0.5 * (sorted[half - 1] + sorted[half]);
}

}  // namespace

double median_variance(std::size_t n) noexcept {
    if (n <= 1) {
        return 1.0;
    }
    if (n == 2) {
        return 0.5;
    }
    // pi/2 divided by the exact variance for n = 3 to 11 exceeds n by 0.45 to 0.50 (odd) and 1.27 to 1.36 (even).
    const double more = n % 2 == 1 ? 0.47 : 1.33;
    return 0.5 * std::numbers::pi / (static_cast<double>(n) + more);
}

double scatter(std::span<const double> readings) noexcept {
    if (readings.size() < 2) {
        return 0.0;
    }
    double mean = 0.0;
    for (const double r : readings) {
        mean += r;
    }
    mean /= static_cast<double>(readings.size());
    double squares = 0.0;
    for (const double r : readings) {
        squares += (r - mean) * (r - mean);
    }
    return std::sqrt(squares / static_cast<double>(readings.size() - 1));
}

bool beyond_chance(double sum_of_squares, double freedom) noexcept {
    if (!(freedom > 0.0)) {
        return false;
    }
    const double spread = 2.0 / (9.0 * freedom);
    const double z = (std::cbrt(sum_of_squares / freedom) - (1.0 - spread)) / std::sqrt(spread);
    return z > kOneInAMillion;
}

Location locate(std::span<const double> readings, double sigma, Estimator estimator) {
    const double middle = median_of(readings);
    if (estimator == Estimator::median) {
        return {.value = middle,
                .sigma = sigma * std::sqrt(median_variance(readings.size())),
                .used = readings.size(),
                .left_out = 0};
    }
    double sum = 0.0;
    std::size_t used = 0;
    for (const double r : readings) {
        if (std::abs(r - middle) <= kWild * sigma) {
            sum += r - middle;
            ++used;
        }
    }
    if (used == 0) {  // two readings, far apart: neither is the wild one
        return {.value = middle, .sigma = std::abs(readings.front() - middle), .used = readings.size(), .left_out = 0};
    }
    return {.value = middle + sum / static_cast<double>(used),
            .sigma = sigma / std::sqrt(static_cast<double>(used)),
            .used = used,
            .left_out = readings.size() - used};
}

}  // namespace sc::host
