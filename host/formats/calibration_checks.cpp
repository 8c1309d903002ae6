// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "host/formats/calibration_units.hpp"
#include "host/formats/text.hpp"
#include "shared/hash/sha256.hpp"

namespace sc::host {

namespace {

/// Rounding of a file with six digits or more.
constexpr double kSymmetryTolerance = 1e-6;

bool is_hash_line(std::string_view line) {
    constexpr std::string_view kKey = "sha256";
    return line.starts_with(kKey) && trimmed(line.substr(kKey.size())).starts_with('=');
}

void add(Sha256& hash, std::string_view text) {
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes of a text.
    hash.update({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace

double asymmetry(const std::vector<std::vector<double>>& matrix) {
    double worst = 0.0;
    for (std::size_t i = 0; i < matrix.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const double scale = std::sqrt(std::abs(matrix[i][i] * matrix[j][j]));
            const double difference = std::abs(matrix[i][j] - matrix[j][i]);
            worst = std::max(worst, scale > 0.0 ? difference / scale : difference);
        }
    }
    return worst;
}

bool is_positive_definite(const std::vector<std::vector<double>>& matrix) {
    const std::size_t n = matrix.size();
    std::vector<double> scale(n);
    for (std::size_t i = 0; i < n; ++i) {
        if (!(matrix[i][i] > 0.0)) {
            return false;
        }
        scale[i] = std::sqrt(matrix[i][i]);
    }
    // Cholesky of the correlation matrix: units do not matter there.
    std::vector<std::vector<double>> lower(n, std::vector<double>(n, 0.0));
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = matrix[i][j] / scale[i] / scale[j];
            for (std::size_t k = 0; k < j; ++k) {
                sum -= lower[i][k] * lower[j][k];
            }
            if (i == j && !(sum > 1e-12)) {
                return false;
            }
            lower[i][j] = i == j ? std::sqrt(sum) : sum / lower[j][j];
        }
    }
    return true;
}

std::vector<std::vector<double>> read_covariance_rows(TomlReader& table, std::string_view order, std::size_t size) {
    if (const std::string found = table.text("covariance_order"); found != order) {
        table.fail("covariance_order", "is not the order of this record", shortened(found),
                   "reorder the covariance to " + std::string(order));
    }
    auto rows = table.matrix("covariance", size, size);
    if (const double off = asymmetry(rows); !(off <= kSymmetryTolerance)) {
        table.fail("covariance", "is not symmetric, relative difference", about(off),
                   "give the covariance matrix in full");
    }
    for (std::size_t i = 0; i < size; ++i) {
        if (!(rows[i][i] > 0.0)) {
            table.fail("covariance",
                       "is not positive: variance " + std::to_string(i + 1) + " of " + std::string(order) + " is",
                       decimal(rows[i][i]), "give variances above zero");
        }
    }
    if (!is_positive_definite(rows)) {
        table.fail("covariance", "is not positive definite", "a combination of " + std::string(order) + " has none",
                   "give a covariance matrix that an estimation made");
    }
    return rows;
}

std::string hash_without_hash_line(std::string_view text) {
    Sha256 hash;
    while (!text.empty()) {
        const std::size_t end = text.find('\n');
        std::string_view line = text.substr(0, end);
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        if (line.ends_with('\r')) {
            line.remove_suffix(1);
        }
        if (!is_hash_line(line)) {
            add(hash, line);
            add(hash, "\n");
        }
    }
    const auto hex = to_hex(hash.digest());
    return {hex.begin(), hex.end()};
}

}  // namespace sc::host
