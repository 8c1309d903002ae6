// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/galvo_model.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Dense>

#include "host/formats/error.hpp"

namespace sc::host {
namespace {

struct Ray {
    FieldPlace focus{};
    FieldPlace lean{};
};

Ray ray_of(const GalvoModel& m, const FieldPlace& command) {
    const auto& v = m.value;
    const double a = v[GalvoModel::kGainX] * command[0] / m.angle_scale;
    const double b = v[GalvoModel::kGainZ] * command[1] / m.angle_scale;
    const double sa = std::sin(a);
    const double sb = std::cos(a) * std::sin(b);
    const double sine = std::hypot(sa, sb);
    const double t = std::atan2(sine, std::cos(a) * std::cos(b));
    const double per_sine = sine > 1e-12 ? t / sine : 1.0;
    const double height =
        (v[GalvoModel::kF1] + (v[GalvoModel::kF2] + (v[GalvoModel::kF3] + v[GalvoModel::kF4] * t) * t) * t) * per_sine;
    const double u = height * sa;
    const double w = height * sb;
    const double cr = std::cos(v[GalvoModel::kRotation]);
    const double sr = std::sin(v[GalvoModel::kRotation]);
    const double cs = std::cos(v[GalvoModel::kRotation] + v[GalvoModel::kSkew]);
    const double ss = std::sin(v[GalvoModel::kRotation] + v[GalvoModel::kSkew]);
    const double bend = 1.0 + v[GalvoModel::kBend] * (u * u + w * w);
    const double lu = u * v[GalvoModel::kExitX] * bend;
    const double lw = w * v[GalvoModel::kExitZ] * bend;
    return {{v[GalvoModel::kOffsetX] + cr * u - ss * w, v[GalvoModel::kOffsetZ] + sr * u + cs * w},
            {v[GalvoModel::kTiltX] + cr * lu - ss * lw, v[GalvoModel::kTiltZ] + sr * lu + cs * lw}};
}

FieldPlace residual_at(const GalvoModel& m, const FieldPlace& command) {
    FieldPlace sum{};
    if (m.residual_side == 0) {
        return sum;
    }
    const ResidualWeights x = residual_weights(command[0], m.residual_half, m.residual_side);
    const ResidualWeights z = residual_weights(command[1], m.residual_half, m.residual_side);
    for (std::size_t j = 0; j < 4; ++j) {
        for (std::size_t i = 0; i < 4; ++i) {
            const FieldPlace& node = m.residual[(z.first + j) * m.residual_side + x.first + i];
            const double weight = x.weight[i] * z.weight[j];
            sum[0] += weight * node[0];
            sum[1] += weight * node[1];
        }
    }
    return sum;
}

/// Where the spline of a GalvoField is made to agree: its knots, and the middles of the first and the last cell.
std::vector<double> sites(double half) {
    const double cell = 2.0 * half / static_cast<double>(GalvoField::kCells);
    std::vector<double> at{-half, -half + 0.5 * cell};
    for (std::size_t i = 1; i < GalvoField::kCells; ++i) {
        at.push_back(-half + cell * static_cast<double>(i));
    }
    at.push_back(half - 0.5 * cell);
    at.push_back(half);
    return at;
}

}  // namespace

ResidualWeights residual_weights(double command, double half, std::size_t side) {
    const std::size_t cells = side - 3;
    const double at = std::clamp((command + half) / (2.0 * half), 0.0, 1.0) * static_cast<double>(cells);
    const std::size_t cell = std::min(static_cast<std::size_t>(at), cells - 1);
    return {cell, spline_weights(at - static_cast<double>(cell)).value};
}

FieldPlace GalvoModel::land(const FieldPlace& command, double depth) const {
    const Ray ray = ray_of(*this, command);
    const FieldPlace left = residual_at(*this, command);
    return {ray.focus[0] + left[0] - depth * ray.lean[0], ray.focus[1] + left[1] - depth * ray.lean[1]};
}

FieldPlace GalvoModel::command_for(const FieldPlace& place) const {
    constexpr double kStep = 1e-6;
    constexpr double kNear = 1e-12;
    FieldPlace command = place;
    for (int i = 0; i < 50; ++i) {
        const FieldPlace here = land(command, 0.0);
        const Eigen::Vector2d error(place[0] - here[0], place[1] - here[1]);
        if (error.norm() < kNear) {
            return command;
        }
        Eigen::Matrix2d slope;
        for (int k = 0; k < 2; ++k) {
            FieldPlace more = command;
            FieldPlace less = command;
            more[static_cast<std::size_t>(k)] += kStep;
            less[static_cast<std::size_t>(k)] -= kStep;
            const FieldPlace a = land(more, 0.0);
            const FieldPlace b = land(less, 0.0);
            slope(0, k) = (a[0] - b[0]) / (2.0 * kStep);
            slope(1, k) = (a[1] - b[1]) / (2.0 * kStep);
        }
        const Eigen::Vector2d step = slope.partialPivLu().solve(error);
        if (!(step.norm() < 0.5)) {
            break;
        }
        command = {command[0] + step.x(), command[1] + step.y()};
        if (step.norm() < kNear) {
            return command;
        }
    }
    throw std::domain_error("the galvo model has no command for a place in the field");
}

GalvoField GalvoModel::field(double half) const {
    GalvoField out;
    out.half = half;
    out.bend = value[kBend];
    const double cr = std::cos(value[kRotation]);
    const double sr = std::sin(value[kRotation]);
    const double cs = std::cos(value[kRotation] + value[kSkew]);
    const double ss = std::sin(value[kRotation] + value[kSkew]);
    Eigen::Matrix2d turn;
    turn << cr, -ss, sr, cs;
    const Eigen::Matrix2d slope = turn * Eigen::Vector2d(value[kExitX], value[kExitZ]).asDiagonal() * turn.inverse();
    const Eigen::Vector2d at_zero =
        Eigen::Vector2d(value[kTiltX], value[kTiltZ]) - slope * Eigen::Vector2d(value[kOffsetX], value[kOffsetZ]);
    out.slope0 = {at_zero.x(), at_zero.y()};
    out.slope = {slope(0, 0), slope(0, 1), slope(1, 0), slope(1, 1)};

    constexpr auto kSide = static_cast<Eigen::Index>(GalvoField::kSide);
    const std::vector<double> at = sites(half);
    Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(kSide, kSide);
    for (Eigen::Index i = 0; i < kSide; ++i) {
        const ResidualWeights w = residual_weights(at[static_cast<std::size_t>(i)], half, GalvoField::kSide);
        for (std::size_t k = 0; k < 4; ++k) {
            basis(i, static_cast<Eigen::Index>(w.first + k)) = w.weight[k];
        }
    }
    std::array<Eigen::MatrixXd, 2> wanted{Eigen::MatrixXd(kSide, kSide), Eigen::MatrixXd(kSide, kSide)};
    for (Eigen::Index j = 0; j < kSide; ++j) {
        for (Eigen::Index i = 0; i < kSide; ++i) {
            const FieldPlace c = command_for({at[static_cast<std::size_t>(i)], at[static_cast<std::size_t>(j)]});
            wanted[0](j, i) = c[0];
            wanted[1](j, i) = c[1];
        }
    }
    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(basis);
    for (std::size_t k = 0; k < 2; ++k) {
        const Eigen::MatrixXd along_z = lu.solve(wanted[k]);
        const Eigen::MatrixXd node = lu.solve(along_z.transpose().eval()).transpose();
        for (Eigen::Index j = 0; j < kSide; ++j) {
            for (Eigen::Index i = 0; i < kSide; ++i) {
                out.node[2 * static_cast<std::size_t>(j * kSide + i) + k] = node(j, i);
            }
        }
    }
    return out;
}

GalvoModel GalvoModel::from(const GalvoFieldRecord& record) {
    GalvoModel model;
    model.angle_scale = record.angle_scale;
    model.value = record.value;
    model.residual_half = record.residual_half;
    model.residual_side = record.residual_side;
    model.residual = record.residual;
    return model;
}

GalvoFieldRecord GalvoModel::record() const {
    return {.angle_scale = angle_scale,
            .value = value,
            .covariance = {},
            .residual_half = residual_half,
            .residual_side = residual_side,
            .residual = residual,
            .provenance = {}};
}

GalvoField galvo_field_of(const CalibrationSet& set) {
    if (!set.galvo_field) {
        return {};
    }
    const auto refuse = [&set](const char* problem) {
        return InputError({.file = set.file.string(),
                           .problem = problem,
                           .value = "galvo_field",
                           .action = "calibrate again: scribecell calibrate galvo-field"});
    };
    try {
        const GalvoField field = GalvoModel::from(*set.galvo_field).field();
        if (!sound(field)) {
            throw refuse("the galvo's field correction is further from nominal than the controller takes");
        }
        return field;
    } catch (const std::domain_error&) {
        throw refuse("the galvo's field correction has no inverse over the field");
    }
}

}  // namespace sc::host
