// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/galvo_residual.hpp"

#include <cmath>
#include <initializer_list>
#include <utility>

#include <Eigen/Dense>

namespace sc::host {
namespace {

/// Stiffnesses of the grid that are tried, four a decade from 1e-3 on.
constexpr int kStiffnesses = 37;
constexpr double kStiffer = 1.7782794;

/// Second differences along both directions and mixed, and a trace of size, which keeps it regular.
Eigen::MatrixXd curvature(std::size_t side) {
    const auto n = static_cast<Eigen::Index>(side * side);
    Eigen::MatrixXd out = 1e-3 * Eigen::MatrixXd::Identity(n, n);
    const auto at = [side](std::size_t i, std::size_t j) { return static_cast<Eigen::Index>(j * side + i); };
    const auto add = [&](std::initializer_list<std::pair<Eigen::Index, double>> terms) {
        for (const auto& [a, p] : terms) {
            for (const auto& [b, q] : terms) {
                out(a, b) += p * q;
            }
        }
    };
    for (std::size_t j = 0; j < side; ++j) {
        for (std::size_t i = 0; i < side; ++i) {
            if (i + 2 < side) {
                add({{at(i, j), 1.0}, {at(i + 1, j), -2.0}, {at(i + 2, j), 1.0}});
            }
            if (j + 2 < side) {
                add({{at(i, j), 1.0}, {at(i, j + 1), -2.0}, {at(i, j + 2), 1.0}});
            }
            if (i + 1 < side && j + 1 < side) {
                const double root = std::sqrt(2.0);
                add({{at(i, j), root}, {at(i + 1, j), -root}, {at(i, j + 1), -root}, {at(i + 1, j + 1), root}});
            }
        }
    }
    return out;
}

}  // namespace

double fit_residual_grid(GalvoModel& model, const std::vector<ResidualSample>& samples, double half, std::size_t side) {
    const auto n = static_cast<Eigen::Index>(side * side);
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n, 2);
    std::vector<Eigen::VectorXd> rows;
    for (const ResidualSample& sample : samples) {
        Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
        const ResidualWeights x = residual_weights(sample.command[0], half, side);
        const ResidualWeights z = residual_weights(sample.command[1], half, side);
        for (std::size_t b = 0; b < 4; ++b) {
            for (std::size_t a = 0; a < 4; ++a) {
                row(static_cast<Eigen::Index>((z.first + b) * side + x.first + a)) = x.weight[a] * z.weight[b];
            }
        }
        normal += sample.weight * row * row.transpose();
        right.col(0) += sample.weight * sample.left[0] * row;
        right.col(1) += sample.weight * sample.left[1] * row;
        rows.push_back(std::move(row));
    }
    const Eigen::MatrixXd penalty = curvature(side);
    double best = 1e300;
    double freedom = 0.0;
    Eigen::MatrixXd nodes;
    double stiffness = 1e-3;
    for (int step = 0; step < kStiffnesses; ++step, stiffness *= kStiffer) {
        const Eigen::LDLT<Eigen::MatrixXd> solver(normal + stiffness * penalty);
        const Eigen::MatrixXd tried = solver.solve(right);
        const double kept = solver.solve(normal).trace();
        double sum = 0.0;
        double count = 0.0;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const double dx = samples[i].left[0] - rows[i].dot(tried.col(0));
            const double dz = samples[i].left[1] - rows[i].dot(tried.col(1));
            sum += samples[i].weight * (dx * dx + dz * dz);
            count += samples[i].weight;
        }
        const double spare = 1.0 - kept / count;
        const double score = sum / (spare * spare);
        if (spare > 0.05 && score < best) {
            best = score;
            nodes = tried;
            freedom = kept;
        }
    }
    if (freedom < 1.0) {
        return 0.0;
    }
    model.residual_half = half;
    model.residual_side = side;
    model.residual.clear();
    for (Eigen::Index i = 0; i < n; ++i) {
        model.residual.push_back({nodes(i, 0), nodes(i, 1)});
    }
    return freedom;
}

}  // namespace sc::host
