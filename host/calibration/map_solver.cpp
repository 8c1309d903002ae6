// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/map_solver.hpp"

#include <algorithm>
#include <cmath>

#include "host/formats/error.hpp"
#include "host/formats/text.hpp"

namespace sc::host {
namespace {

constexpr double kFirstNoise = 1e-6;
constexpr double kSmallestNoise = 1e-8;
constexpr double kOutlier = 6.0;
constexpr double kOutlierFloor = 3e-6;
constexpr double kTakeUpShare = 0.1;

}  // namespace

SplineCell spline_cell(double place, double first, double spacing, std::size_t intervals) {
    const double u = std::clamp((place - first) / spacing, 0.0, static_cast<double>(intervals) - 1e-6);
    SplineCell cell;
    cell.first = static_cast<std::size_t>(u);
    const double f = u - static_cast<double>(cell.first);
    const double g = 1.0 - f;
    cell.weight = {g * g * g / 6.0, (4.0 - 3.0 * f * f * (2.0 - f)) / 6.0, (4.0 - 3.0 * g * g * (2.0 - g)) / 6.0,
                   f * f * f / 6.0};
    return cell;
}

MapSolver::MapSolver(std::size_t unknowns)
    : unknowns_(unknowns),
      prior_(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(unknowns), static_cast<Eigen::Index>(unknowns))),
      prior_value_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(unknowns))) {}

void MapSolver::believe(const Eigen::VectorXd& row, double value, double sigma) {
    prior_ += row * row.transpose() / (sigma * sigma);
    prior_value_ += row * (value / (sigma * sigma));
}

void MapSolver::measure(const Eigen::VectorXd& row, double value, int line) {
    row_.push_back(row);
    value_.push_back(value);
    line_.push_back(line);
}

double MapSolver::residual(std::size_t i) const { return value_[i] - row_[i].dot(solution_); }

void MapSolver::solve_with(double noise) {
    Eigen::MatrixXd normal = prior_;
    Eigen::VectorXd right = prior_value_;
    const double weight = 1.0 / (noise * noise);
    for (std::size_t i = 0; i < value_.size(); ++i) {
        normal.noalias() += (weight * row_[i]) * row_[i].transpose();
        right += row_[i] * (weight * value_[i]);
    }
    factor_.compute(normal);
    solution_ = factor_.solve(right);
}

void MapSolver::solve() {
    solve_with(kFirstNoise);
    const double freedom = std::max(1.0, static_cast<double>(value_.size()) - 0.5 * static_cast<double>(unknowns_));
    noise_ = std::max(kSmallestNoise, residual_rms() * std::sqrt(static_cast<double>(value_.size()) / freedom));
    solve_with(noise_);
}

double MapSolver::sigma_of(const Eigen::VectorXd& row) const { return std::sqrt(row.dot(factor_.solve(row))); }

double MapSolver::residual_rms() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < value_.size(); ++i) {
        sum += residual(i) * residual(i);
    }
    return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(value_.size(), 1)));
}

double MapSolver::residual_max() const {
    double worst = 0.0;
    for (std::size_t i = 0; i < value_.size(); ++i) {
        worst = std::max(worst, std::abs(residual(i)));
    }
    return worst;
}

int MapSolver::worst_line() const {
    std::size_t worst = 0;
    for (std::size_t i = 0; i < value_.size(); ++i) {
        worst = std::abs(residual(i)) > std::abs(residual(worst)) ? i : worst;
    }
    return line_[worst];
}

void refuse_fit(const std::filesystem::path& file, int line, const std::string& problem, const std::string& value,
                const std::string& action) {
    throw InputError({.file = file.string(), .line = line, .problem = problem, .value = value, .action = action});
}

void refuse_outlier(const MapSolver& solver, const std::filesystem::path& file, double unit) {
    const double worst = solver.residual_max();
    if (worst > kOutlierFloor / unit && worst > kOutlier * solver.residual_rms()) {
        refuse_fit(file, solver.worst_line(), "a point is far off what all others say, um", about(worst * unit * 1e6),
                   "measure it again, or remove the line");
    }
}

double take_up_for(double backlash, const AxisConfig& axis) {
    const double time = std::cbrt(32.0 * backlash / (kTakeUpShare * axis.jerk));
    return std::max(0.005, std::ceil(time * 1e3) * 1e-3);
}

void refuse_bad_map(const AxisMap& map, const MachineConfig& machine, const std::filesystem::path& file) {
    MapCost cost;
    const MapFinding finding = check_map(machine, map, cost);
    if (finding.refusal == Refusal::none) {
        return;
    }
    const CodeText* code = find_code(finding.refusal);
    const std::string where =
        std::string("axis ") + "XYZC"[finding.axis] + ", " +
        (finding.along == MapFinding::kBacklash ? std::string("backlash")
                                                : std::string("table along ") + "XYZC"[finding.along]) +
        ", node " + std::to_string(finding.node);
    refuse_fit(file, 0, std::string(code->text), where, std::string(code->action));
}

}  // namespace sc::host
