// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/hand_eye_fit.hpp"

#include <array>
#include <cmath>

namespace sc::host {
namespace {

// A sensor sits on the flange somehow, within 10 m: that keeps the equations regular when poses say nothing of it.
constexpr double kAnyPlace = 10.0;
constexpr double kAnyTurn = 3.0;
constexpr double kLever = 0.2;  ///< metres, at which a turn counts as a place

Eigen::Vector3d predicted(const HandEyeState& state, const HandEyeSight& sight) {
    const Motion& robot = state.robot[static_cast<std::size_t>(sight.view)];
    const Eigen::Vector3d in_f = robot.r.transpose() * (state.at[static_cast<std::size_t>(sight.marker)] - robot.t);
    return state.x.r.transpose() * (in_f - state.x.t);
}

double cost_of(const HandEyeProblem& problem, const HandEyeState& state) {
    double sum = 0.0;
    for (const HandEyeSight& sight : problem.sights) {
        const Eigen::Vector3d r = sight_residual(state, sight);
        sum += r.cwiseAbs2().dot(sight.weight);
    }
    for (std::size_t i = 0; i < problem.read.size(); ++i) {
        const auto change = pose_change(problem.read[i], state.robot[i]);
        sum += change.head<3>().squaredNorm() / (problem.turn_sigma * problem.turn_sigma) +
               change.tail<3>().squaredNorm() / (problem.place_sigma * problem.place_sigma);
    }
    return sum;
}

HandEyeSystem system_of(const HandEyeProblem& problem, const HandEyeState& state) {
    HandEyeSystem system(6 + 3 * problem.markers, problem.read.size());
    for (const HandEyeSight& sight : problem.sights) {
        const Motion& robot = state.robot[static_cast<std::size_t>(sight.view)];
        const Eigen::Vector3d in_f = robot.r.transpose() * (state.at[static_cast<std::size_t>(sight.marker)] - robot.t);
        const Eigen::Matrix3d c_from_f = state.x.r.transpose();
        std::array<HandEyeSystem::Part, 2> parts;
        parts[0].at = 0;
        parts[0].jacobian.resize(3, 6);
        parts[0].jacobian << c_from_f * skew(in_f - state.x.t), -c_from_f;
        parts[1].at = 6 + 3 * static_cast<Eigen::Index>(sight.marker);
        parts[1].jacobian = c_from_f * robot.r.transpose();
        HandEyeSystem::ViewJacobian own;
        own << c_from_f * skew(in_f), -c_from_f * robot.r.transpose();
        system.add(static_cast<std::size_t>(sight.view), sight_residual(state, sight), sight.weight, parts, own);
    }
    HandEyeSystem::ViewVector weight;
    weight.head<3>().setConstant(1.0 / (problem.turn_sigma * problem.turn_sigma));
    weight.tail<3>().setConstant(1.0 / (problem.place_sigma * problem.place_sigma));
    for (std::size_t i = 0; i < problem.read.size(); ++i) {
        system.add_prior(i, -pose_change(problem.read[i], state.robot[i]), weight);
    }
    for (Eigen::Index i = 0; i < 3; ++i) {
        system.add_common_prior(i, 0.0, 1.0 / (kAnyTurn * kAnyTurn));
        system.add_common_prior(3 + i, 0.0, 1.0 / (kAnyPlace * kAnyPlace));
    }
    return system;
}

HandEyeState moved(const HandEyeState& state, const HandEyeSystem::Step& step) {
    HandEyeState next = state;
    next.x.r = exp_turn(step.common.head<3>()) * state.x.r;
    next.x.t += step.common.segment<3>(3);
    for (std::size_t k = 0; k < next.at.size(); ++k) {
        next.at[k] += step.common.segment<3>(6 + 3 * static_cast<Eigen::Index>(k));
    }
    for (std::size_t i = 0; i < next.robot.size(); ++i) {
        next.robot[i].r = state.robot[i].r * exp_turn(step.own[i].head<3>());
        next.robot[i].t += step.own[i].tail<3>();
    }
    return next;
}

template <class Visit>
void for_each_motion(const std::vector<Motion>& f, const std::vector<Motion>& c, const Visit& visit) {
    for (std::size_t i = 0; i < f.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            visit(f[j].inverse() * f[i], c[j] * c[i].inverse(), i, j);
        }
    }
}

double angle_of(const Eigen::Matrix3d& r) { return std::atan2(0.5 * axial(r).norm(), 0.5 * (r.trace() - 1.0)); }

double scatter_of(const std::vector<Motion>& f, const std::vector<Motion>& c, const Motion& x) {
    std::vector<Motion> seen;
    Motion mean{Eigen::Matrix3d::Zero(), Eigen::Vector3d::Zero()};
    const double n = static_cast<double>(f.size());
    for (std::size_t i = 0; i < f.size(); ++i) {
        seen.push_back(f[i] * x * c[i]);
        mean.r += seen.back().r / n;
        mean.t += seen.back().t / n;
    }
    mean.r = nearest_turn(mean.r);
    double sum = 0.0;
    for (const Motion& m : seen) {
        sum += (m.t - mean.t).squaredNorm() + kLever * kLever * log_turn(mean.r.transpose() * m.r).squaredNorm();
    }
    return std::sqrt(sum / n);
}

}  // namespace

Eigen::Vector3d sight_residual(const HandEyeState& state, const HandEyeSight& sight) {
    return sight.place - predicted(state, sight);
}

Eigen::Matrix<double, 6, 1> pose_change(const Motion& read, const Motion& now) {
    Eigen::Matrix<double, 6, 1> out;
    out << log_turn(read.r.transpose() * now.r), now.t - read.t;
    return out;
}

HandEyeState start_state(const HandEyeProblem& problem, const Motion& x) {
    HandEyeState state{x, problem.read, {}};
    state.at.assign(static_cast<std::size_t>(problem.markers), Eigen::Vector3d::Zero());
    std::vector<double> seen(state.at.size(), 0.0);
    for (const HandEyeSight& sight : problem.sights) {
        const auto k = static_cast<std::size_t>(sight.marker);
        state.at[k] += state.robot[static_cast<std::size_t>(sight.view)] * (x * sight.place);
        seen[k] += 1.0;
    }
    for (std::size_t k = 0; k < seen.size(); ++k) {
        state.at[k] /= seen[k] > 0.0 ? seen[k] : 1.0;
    }
    return state;
}

HandEyeFit fit_hand_eye(const HandEyeProblem& problem, const HandEyeState& start) {
    HandEyeFit fit;
    fit.state = start;
    fit.chi_squared = minimise(
        fit.state, [&](const HandEyeState& s) { return system_of(problem, s); },
        [&](const HandEyeState& s) { return cost_of(problem, s); }, moved);
    fit.spread = system_of(problem, fit.state).covariance();
    return fit;
}

HandEyeStart start_hand_eye(const std::vector<Motion>& f, const std::vector<Motion>& c) {
    Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
    double pairs = 0.0;
    for_each_motion(f, c, [&](const Motion& a, const Motion& b, std::size_t, std::size_t) {
        const Eigen::Vector3d turn = axial(a.r);
        cross += turn * axial(b.r).transpose();
        own += turn * turn.transpose();
        pairs += 1.0;
    });
    HandEyeStart out;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> turns(own / pairs);
    out.turned = turns.eigenvalues().reverse().cwiseMax(0.0).cwiseSqrt();
    out.turned_about = turns.eigenvectors().rowwise().reverse();
    out.x.r = nearest_turn(cross);
    Eigen::Matrix3d left = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for_each_motion(f, c, [&](const Motion& a, const Motion& b, std::size_t, std::size_t) {
        const Eigen::Matrix3d m = a.r - Eigen::Matrix3d::Identity();
        left += m.transpose() * m;
        right += m.transpose() * (out.x.r * b.t - a.t);
    });
    // What no motion shows stays zero.
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> places(left);
    for (Eigen::Index i = 0; i < 3; ++i) {
        if (places.eigenvalues()[i] > 1e-10 * pairs) {
            const Eigen::Vector3d u = places.eigenvectors().col(i);
            out.x.t += u.dot(right) / places.eigenvalues()[i] * u;
        }
    }
    out.scatter = scatter_of(f, c, out.x);
    return out;
}

double angle_mismatch(const std::vector<Motion>& f, const std::vector<Motion>& c, int shift) {
    std::vector<Motion> a;
    std::vector<Motion> b;
    for (int i = 0; i < static_cast<int>(f.size()); ++i) {
        const int k = i + shift;
        if (k >= 0 && k < static_cast<int>(c.size())) {
            a.push_back(f[static_cast<std::size_t>(i)]);
            b.push_back(c[static_cast<std::size_t>(k)]);
        }
    }
    double sum = 0.0;
    double pairs = 0.0;
    for_each_motion(a, b, [&](const Motion& m, const Motion& n, std::size_t, std::size_t) {
        const double off = angle_of(m.r) - angle_of(n.r);
        sum += off * off;
        pairs += 1.0;
    });
    return pairs > 0.0 ? std::sqrt(sum / pairs) : 0.0;
}

std::vector<bool> out_of_step(const std::vector<Motion>& f, const std::vector<Motion>& c, double limit) {
    const std::size_t n = f.size();
    Eigen::MatrixXi wrong = Eigen::MatrixXi::Zero(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
    for_each_motion(f, c, [&](const Motion& a, const Motion& b, std::size_t i, std::size_t j) {
        const int is_wrong = std::abs(angle_of(a.r) - angle_of(b.r)) > limit ? 1 : 0;
        wrong(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = is_wrong;
        wrong(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i)) = is_wrong;
    });
    std::vector<bool> out(n, false);
    for (std::size_t round = 0; round < n; ++round) {
        Eigen::Index worst = 0;
        const int most = wrong.rowwise().sum().maxCoeff(&worst);
        const auto left = static_cast<int>(n - round) - 1;
        if (left < 3 || 2 * most <= left) {
            break;
        }
        out[static_cast<std::size_t>(worst)] = true;
        wrong.row(worst).setZero();
        wrong.col(worst).setZero();
    }
    return out;
}

}  // namespace sc::host
