// SPDX-License-Identifier: Apache-2.0
#include "host/registration/chain_fit.hpp"

#include <array>
#include <cmath>

#include "host/calibration/bordered_system.hpp"

namespace sc::host {
namespace {

// A view stands somewhere within 30 m: that keeps the equations regular where the data say nothing.
constexpr double kAnyPlace = 30.0;
constexpr double kAnyTurn = 10.0;
/// c is the frame of the first view: what its pose is known to, so that it does not move.
constexpr double kPinned = 1e-9;

double cost_of(const ChainModel& model, const ChainState& state) {
    double sum = 0.0;
    for (const ChainSight& sight : model.sights) {
        if (sight.used) {
            sum += chain_residual(model, state, sight).cwiseAbs2().dot(sight.weight);
        }
    }
    for (std::size_t i = 0; i < model.stops.size(); ++i) {
        sum += model.stops[i].weight * state.off[i] * state.off[i];
    }
    for (const ChainKnown& k : model.known) {
        sum += k.weight * (k.place - state.at[k.marker]).squaredNorm();
    }
    for (const ChainRead& read : model.reads) {
        const auto r = read_residual(state, read);
        sum += r.head<3>().squaredNorm() / (model.robot_turn * model.robot_turn) +
               r.tail<3>().squaredNorm() / (model.robot_place * model.robot_place);
    }
    return sum;
}

/// d reading of the robot / d view's pose, c_from_b, f_from_s.
std::array<ChainSystem::PriorPart, 3> read_slope(const ChainModel& model, const ChainState& state,
                                                 const ChainRead& read) {
    const Motion& view = state.pose[read.pose];
    const Eigen::Matrix3d b_from_c = state.c_from_b.r.transpose();
    const Eigen::Matrix3d c_from_f = view.r * state.f_from_s.r.transpose();
    const Eigen::Vector3d lever = -(c_from_f * state.f_from_s.t);  // from the view's origin to the flange's, in c
    const Eigen::Vector3d flange = lever + view.t - state.c_from_b.t;
    std::array<ChainSystem::PriorPart, 3> out;
    for (ChainSystem::PriorPart& part : out) {
        part.jacobian.setZero();
    }
    out[0].at = model.pose_at(read.pose);
    out[0].jacobian.topLeftCorner<3, 3>() = b_from_c;
    out[0].jacobian.bottomLeftCorner<3, 3>() = -b_from_c * skew(lever);
    out[0].jacobian.bottomRightCorner<3, 3>() = b_from_c;
    out[1].at = model.robot_at();
    out[1].jacobian.topLeftCorner<3, 3>() = -b_from_c;
    out[1].jacobian.bottomLeftCorner<3, 3>() = b_from_c * skew(flange);
    out[1].jacobian.bottomRightCorner<3, 3>() = -b_from_c;
    out[2].at = model.robot_at() + 6;
    out[2].jacobian.topLeftCorner<3, 3>() = -b_from_c * c_from_f;
    out[2].jacobian.bottomLeftCorner<3, 3>() = -b_from_c * c_from_f * skew(state.f_from_s.t);
    out[2].jacobian.bottomRightCorner<3, 3>() = -b_from_c * c_from_f;
    return out;
}

Eigen::Matrix<double, 6, 1> robot_weight(const ChainModel& model) {
    Eigen::Matrix<double, 6, 1> out;
    out.head<3>().setConstant(1.0 / (model.robot_turn * model.robot_turn));
    out.tail<3>().setConstant(1.0 / (model.robot_place * model.robot_place));
    return out;
}

ChainSystem system_of(const ChainModel& model, const ChainState& state) {
    ChainSystem system(model.common(), model.turning.size());
    for (const ChainSight& sight : model.sights) {
        if (!sight.used) {
            continue;
        }
        const double turn = model.stops[sight.stop].turn + state.off[sight.stop];
        const ChainSlope slope = chain_slope(model, state, sight.pose, sight.marker, turn, sight.stop);
        system.add(sight.marker, chain_residual(model, state, sight), sight.weight, slope.parts, slope.own);
    }
    for (std::size_t i = 0; i < model.stops.size(); ++i) {
        const double some = 1.0 / (kAnyTurn * kAnyTurn);
        system.know(model.stop_at(i), -state.off[i], model.stops[i].weight > 0.0 ? model.stops[i].weight : some);
    }
    for (const ChainKnown& k : model.known) {
        system.know_marker(k.marker, k.place - state.at[k.marker], k.weight);
    }
    for (std::size_t i = 0; i < model.turning.size(); ++i) {
        system.know_marker(i, Eigen::Vector3d::Zero(), 1.0 / (kAnyPlace * kAnyPlace));
    }
    for (Eigen::Index i = 0; i < model.common(); ++i) {
        const bool pinned = i < 6 && model.known.empty();
        const double sigma = pinned ? kPinned : kAnyPlace;
        system.know(i, 0.0, 1.0 / (sigma * sigma));
    }
    for (const ChainRead& read : model.reads) {
        system.add_pose(read_residual(state, read), robot_weight(model), read_slope(model, state, read));
    }
    return system;
}

void turn_and_shift(Motion& motion, const Eigen::VectorXd& step, Eigen::Index at) {
    motion.r = exp_turn(step.segment<3>(at)) * motion.r;
    motion.t += step.segment<3>(at + 3);
}

}  // namespace

Eigen::Matrix<double, 3, 2> across_of(const Eigen::Vector3d& direction) {
    Eigen::Matrix<double, 3, 2> out;
    const Eigen::Vector3d other = std::abs(direction[0]) < 0.6 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
    out.col(0) = direction.cross(other).normalized();
    out.col(1) = direction.cross(out.col(0));
    return out;
}

Eigen::Vector3d chain_place(const ChainState& state, bool turning, const Eigen::Vector3d& at, double turn) {
    return turning ? Eigen::Vector3d(state.point + exp_turn(turn * state.direction) * (at - state.point)) : at;
}

Eigen::Vector3d chain_residual(const ChainModel& model, const ChainState& state, const ChainSight& sight) {
    const double turn = model.stops[sight.stop].turn + state.off[sight.stop];
    const Eigen::Vector3d q = chain_place(state, model.turning[sight.marker], state.at[sight.marker], turn);
    const Motion& pose = state.pose[sight.pose];
    return sight.place - pose.r.transpose() * (q - pose.t);
}

ChainSlope chain_slope(const ChainModel& model, const ChainState& state, std::size_t pose, std::size_t marker,
                       double turn, std::optional<std::size_t> stop) {
    const Motion& from = state.pose[pose];
    const Eigen::Matrix3d back = from.r.transpose();
    const Eigen::Vector3d q = chain_place(state, model.turning[marker], state.at[marker], turn);
    ChainSlope out;
    out.parts.resize(1);
    out.parts[0].at = model.pose_at(pose);
    out.parts[0].jacobian.resize(3, 6);
    out.parts[0].jacobian << back * skew(q - from.t), -back;
    out.own = back;
    if (!model.turning[marker]) {
        return out;
    }
    const Eigen::Matrix3d r = exp_turn(turn * state.direction);
    const Eigen::Vector3d arm = state.at[marker] - state.point;
    const Eigen::Vector3d turned = r * arm;
    out.own = back * r;
    out.by_turn = back * state.direction.cross(turned);
    if (model.has_axis) {
        ChainSystem::Part axis;
        axis.at = model.axis_at();
        axis.jacobian.resize(3, 4);
        axis.jacobian.leftCols<2>() = back * (Eigen::Matrix3d::Identity() - r) * state.across;
        // The direction turns by ω: R becomes Exp(ω) R Exp(−ω).
        const Eigen::Matrix3d by_tilt = r * skew(arm) - skew(turned);
        for (Eigen::Index k = 0; k < 2; ++k) {
            axis.jacobian.col(2 + k) = back * by_tilt * state.direction.cross(Eigen::Vector3d(state.across.col(k)));
        }
        out.parts.push_back(axis);
    }
    if (stop) {
        ChainSystem::Part angle;
        angle.at = model.stop_at(*stop);
        angle.jacobian = out.by_turn;
        out.parts.push_back(angle);
    }
    return out;
}

Eigen::Matrix<double, 6, 1> read_residual(const ChainState& state, const ChainRead& read) {
    const Motion now = state.c_from_b.inverse() * state.pose[read.pose] * state.f_from_s.inverse();
    Eigen::Matrix<double, 6, 1> out;
    out << log_turn(read.b_from_f.r * now.r.transpose()), read.b_from_f.t - now.t;
    return out;
}

double fit_chain_state(const ChainModel& model, ChainState& state) {
    const auto moved = [&model](const ChainState& from, const ChainSystem::Step& step) {
        ChainState next = from;
        for (std::size_t i = 0; i < model.poses; ++i) {
            turn_and_shift(next.pose[i], step.common, model.pose_at(i));
        }
        for (std::size_t i = 0; i < model.stops.size(); ++i) {
            next.off[i] += step.common[model.stop_at(i)];
        }
        if (model.has_axis) {
            const Eigen::Vector4d s = step.common.segment<4>(model.axis_at());
            next.point += from.across * s.head<2>();
            next.direction =
                exp_turn(from.direction.cross(Eigen::Vector3d(from.across * s.tail<2>()))) * from.direction;
            next.direction.normalize();
            next.across = across_of(next.direction);
        }
        if (!model.reads.empty()) {
            turn_and_shift(next.c_from_b, step.common, model.robot_at());
            turn_and_shift(next.f_from_s, step.common, model.robot_at() + 6);
        }
        for (std::size_t i = 0; i < next.at.size(); ++i) {
            next.at[i] += step.markers[i];
        }
        return next;
    };
    return minimise(
        state, [&model](const ChainState& s) { return system_of(model, s); },
        [&model](const ChainState& s) { return cost_of(model, s); }, moved);
}

ChainSystem::Spread chain_spread(const ChainModel& model, const ChainState& state) {
    return system_of(model, state).covariance();
}

double robot_ratio(const ChainModel& model, const ChainState& state, const ChainSystem::Spread& spread) {
    const Eigen::Matrix<double, 6, 1> weight = robot_weight(model);
    double squares = 0.0;
    double freedom = 0.0;
    for (const ChainRead& read : model.reads) {
        const auto slope = read_slope(model, state, read);
        Eigen::Matrix<double, 6, 6> of_fit = Eigen::Matrix<double, 6, 6>::Zero();
        for (const ChainSystem::PriorPart& p : slope) {
            for (const ChainSystem::PriorPart& q : slope) {
                of_fit += p.jacobian * spread.common().block<6, 6>(p.at, q.at) * q.jacobian.transpose();
            }
        }
        squares += read_residual(state, read).cwiseAbs2().dot(weight);
        freedom += 6.0 - of_fit.diagonal().dot(weight);
    }
    return freedom > 1.0 ? std::sqrt(squares / freedom) : 1.0;
}

}  // namespace sc::host
