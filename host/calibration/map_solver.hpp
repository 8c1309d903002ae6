// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "host/calibration/axis_map_fit.hpp"

/// What both fits of the axis map share, for the sources of this folder only.

namespace sc::host {

/// Weights of the four coefficients about a place, as the controller forms them.
struct SplineCell {
    std::size_t first = 0;
    std::array<double, 4> weight{};
};
/// `nodes` intervals from `first` on; the place is limited to them.
[[nodiscard]] SplineCell spline_cell(double place, double first, double spacing, std::size_t intervals);

/// Linear least squares with priors: rows in units of their sigma.
class MapSolver {
public:
    explicit MapSolver(std::size_t unknowns);
    /// A prior belief: row · unknowns = value, to `sigma`.
    void believe(const Eigen::VectorXd& row, double value, double sigma);
    /// A measurement; all have one sigma, which is found from the residuals.
    void measure(const Eigen::VectorXd& row, double value, int line);
    /// Twice: the noise from a first solution weighs the priors of the second.
    void solve();

    [[nodiscard]] const Eigen::VectorXd& solution() const noexcept { return solution_; }
    [[nodiscard]] double noise() const noexcept { return noise_; }
    /// Standard deviation of row · solution.
    [[nodiscard]] double sigma_of(const Eigen::VectorXd& row) const;
    [[nodiscard]] double residual_rms() const;
    [[nodiscard]] double residual_max() const;
    [[nodiscard]] std::size_t measurements() const noexcept { return value_.size(); }
    /// Line of the file whose residual is largest.
    [[nodiscard]] int worst_line() const;

private:
    void solve_with(double noise);
    [[nodiscard]] double residual(std::size_t i) const;

    std::size_t unknowns_;
    Eigen::MatrixXd prior_;
    Eigen::VectorXd prior_value_;
    std::vector<Eigen::VectorXd> row_;
    std::vector<double> value_;
    std::vector<int> line_;
    Eigen::VectorXd solution_;
    Eigen::LDLT<Eigen::MatrixXd> factor_;
    double noise_ = 0.0;
};

/// Throws InputError.
[[noreturn]] void refuse_fit(const std::filesystem::path& file, int line, const std::string& problem,
                             const std::string& value, const std::string& action);
/// Refuses a point that is more than six times further off than the rest (and more than 3 µm).
void refuse_outlier(const MapSolver& solver, const std::filesystem::path& file, double unit);
/// The quickest take-up, whole ms, that stays within a tenth of the axis' jerk.
[[nodiscard]] double take_up_for(double backlash, const AxisConfig& axis);
/// Refuses a map that the machine's controller would refuse.
void refuse_bad_map(const AxisMap& map, const MachineConfig& machine, const std::filesystem::path& file);

}  // namespace sc::host
