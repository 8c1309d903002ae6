// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/board_bundle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

namespace sc::host {
namespace {

constexpr Eigen::Index kNine = static_cast<Eigen::Index>(CameraModel::kParameters);
constexpr Eigen::Index kFirstPart = 4;  ///< focal lengths and middle; the distortion is the second part
constexpr double kFixedWeight = 1e30;   ///< of a parameter that stays
constexpr double kFlat = 1e-9;          ///< least singular value but one, over the largest

BoardSystem system_of(const BoardBundle& bundle, const BoardState& state) {
    const std::size_t cameras = state.cameras.size();
    BoardSystem system(common_size(cameras), state.boards.size());
    for (const BoardSight& sight : bundle.sights) {
        const Motion& board = state.boards[sight.view];
        const Eigen::Vector3d turned = board.r * sight.place;
        const Eigen::Vector3d left = turned + board.t;
        const bool right = sight.camera == 1;
        const Eigen::Vector3d at = right ? state.right_from_left * left : left;
        const auto slopes = project_with_slopes(state.cameras[sight.camera], to_vec(at));
        if (!slopes) {
            continue;
        }
        Eigen::Matrix3d by_place = Eigen::Matrix3d::Zero();  // the third row is nothing's
        std::vector<BoardSystem::Part> parts(right ? 3 : 2);
        const Eigen::Index first = kNine * static_cast<Eigen::Index>(sight.camera);
        parts[0].at = first;
        parts[0].jacobian.setZero(3, kFirstPart);
        parts[1].at = first + kFirstPart;
        parts[1].jacobian.setZero(3, kNine - kFirstPart);
        for (Eigen::Index i = 0; i < 2; ++i) {
            const auto row = static_cast<std::size_t>(i);
            for (Eigen::Index k = 0; k < kNine; ++k) {
                const double slope = slopes->by_camera[row][static_cast<std::size_t>(k)];
                (k < kFirstPart ? parts[0].jacobian(i, k) : parts[1].jacobian(i, k - kFirstPart)) = slope;
            }
            for (Eigen::Index k = 0; k < 3; ++k) {
                by_place(i, k) = slopes->by_place[row][static_cast<std::size_t>(k)];
            }
        }
        if (right) {
            parts[2].at = 2 * kNine;
            parts[2].jacobian.setZero(3, 6);
            parts[2].jacobian.leftCols<3>() = -by_place * skew(state.right_from_left.r * left);
            parts[2].jacobian.rightCols<3>() = by_place;
            by_place = by_place * state.right_from_left.r;
        }
        BoardSystem::ViewJacobian own;
        own.leftCols<3>() = -by_place * skew(turned);
        own.rightCols<3>() = by_place;
        const Eigen::Vector3d residual(sight.seen[0] - slopes->at[0], sight.seen[1] - slopes->at[1], 0.0);
        system.add(sight.view, residual, Eigen::Vector3d::Constant(sight.weight), parts, own);
    }
    // A view that is left out stays where it is.
    std::vector<bool> seen(state.boards.size(), false);
    for (const BoardSight& sight : bundle.sights) {
        seen[sight.view] = true;
    }
    for (std::size_t v = 0; v < seen.size(); ++v) {
        if (!seen[v]) {
            system.add_prior(v, BoardSystem::ViewVector::Zero(), BoardSystem::ViewVector::Ones());
        }
    }
    for (std::size_t c = 0; c < cameras; ++c) {
        for (std::size_t k = 0; k < CameraModel::kParameters; ++k) {
            if (bundle.fixed[c][k]) {
                system.add_common_prior(kNine * static_cast<Eigen::Index>(c) + static_cast<Eigen::Index>(k), 0.0,
                                        kFixedWeight);
            }
        }
    }
    return system;
}

void move(Motion& motion, const Eigen::Ref<const Eigen::VectorXd>& step) {
    motion.r = exp_turn(step.head<3>()) * motion.r;
    motion.t += step.tail<3>();
}

BoardState moved(const BoardBundle& bundle, const BoardState& state, const BoardSystem::Step& step) {
    BoardState out = state;
    for (std::size_t c = 0; c < out.cameras.size(); ++c) {
        CameraModel& camera = out.cameras[c];
        std::array<double*, CameraModel::kParameters> all{&camera.focal_x, &camera.focal_y, &camera.middle_x,
                                                          &camera.middle_y};
        for (std::size_t k = 0; k < camera.distortion.size(); ++k) {
            all[4 + k] = &camera.distortion[k];
        }
        for (std::size_t k = 0; k < all.size(); ++k) {
            if (!bundle.fixed[c][k]) {
                *all[k] += step.common[kNine * static_cast<Eigen::Index>(c) + static_cast<Eigen::Index>(k)];
            }
        }
    }
    if (out.cameras.size() > 1) {
        move(out.right_from_left, step.common.tail<6>());
    }
    for (std::size_t v = 0; v < out.boards.size(); ++v) {
        move(out.boards[v], step.own[v]);
    }
    return out;
}

/// Moves to mean 0 and scales to mean distance 1.
Eigen::Matrix3d normaliser(std::span<const PlanePair> pairs, bool seen) {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const PlanePair& p : pairs) {
        mean += seen ? p.seen : p.board;
    }
    mean /= static_cast<double>(pairs.size());
    double far = 0.0;
    for (const PlanePair& p : pairs) {
        far += ((seen ? p.seen : p.board) - mean).norm();
    }
    const double scale = far > 0.0 ? static_cast<double>(pairs.size()) / far : 1.0;
    Eigen::Matrix3d out;
    out << scale, 0.0, -scale * mean[0], 0.0, scale, -scale * mean[1], 0.0, 0.0, 1.0;
    return out;
}

}  // namespace

Eigen::Index common_size(std::size_t cameras) {
    return kNine * static_cast<Eigen::Index>(cameras) + (cameras > 1 ? 6 : 0);
}

Eigen::Vector2d predicted(const BoardState& state, const BoardSight& sight) {
    const Eigen::Vector3d left = state.boards[sight.view] * sight.place;
    const auto seen = project(state.cameras[sight.camera],
                              to_vec(sight.camera == 1 ? Eigen::Vector3d(state.right_from_left * left) : left));
    const double none = std::numeric_limits<double>::quiet_NaN();
    return seen ? Eigen::Vector2d((*seen)[0], (*seen)[1]) : Eigen::Vector2d(none, none);
}

double cost_of(const BoardBundle& bundle, const BoardState& state) {
    double sum = 0.0;
    for (const BoardSight& sight : bundle.sights) {
        sum += sight.weight * (sight.seen - predicted(state, sight)).squaredNorm();
    }
    return sum;
}

double refine(const BoardBundle& bundle, BoardState& state, int rounds) {
    return minimise(
        state, [&](const BoardState& s) { return system_of(bundle, s); },
        [&](const BoardState& s) { return cost_of(bundle, s); },
        [&](const BoardState& s, const BoardSystem::Step& step) { return moved(bundle, s, step); }, rounds);
}

BoardSystem::Spread spread_of(const BoardBundle& bundle, const BoardState& state) {
    BoardSystem::Spread out = system_of(bundle, state).covariance();
    for (std::size_t c = 0; c < state.cameras.size(); ++c) {
        for (std::size_t k = 0; k < CameraModel::kParameters; ++k) {
            if (bundle.fixed[c][k]) {
                const Eigen::Index at = kNine * static_cast<Eigen::Index>(c) + static_cast<Eigen::Index>(k);
                out.common.row(at).setZero();
                out.common.col(at).setZero();
            }
        }
    }
    return out;
}

std::optional<Eigen::Matrix3d> homography_of(std::span<const PlanePair> pairs) {
    if (pairs.size() < 4) {
        return std::nullopt;
    }
    const Eigen::Matrix3d to_board = normaliser(pairs, false);
    const Eigen::Matrix3d to_seen = normaliser(pairs, true);
    Eigen::MatrixXd rows(2 * static_cast<Eigen::Index>(pairs.size()), 9);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const Eigen::Vector3d b = to_board * pairs[i].board.homogeneous();
        const Eigen::Vector3d s = to_seen * pairs[i].seen.homogeneous();
        const auto at = 2 * static_cast<Eigen::Index>(i);
        rows.row(at) << b.transpose(), 0.0, 0.0, 0.0, -s[0] * b.transpose();
        rows.row(at + 1) << 0.0, 0.0, 0.0, b.transpose(), -s[1] * b.transpose();
    }
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows, Eigen::ComputeFullV);
    if (!(svd.singularValues()[7] > kFlat * svd.singularValues()[0])) {
        return std::nullopt;
    }
    const Eigen::VectorXd h = svd.matrixV().col(8);
    Eigen::Matrix3d out;
    out << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8];
    out = to_seen.inverse() * out * to_board;
    return out.allFinite() && std::abs(out.determinant()) > 0.0 ? std::optional(out) : std::nullopt;
}

std::optional<Eigen::Matrix3d> robust_homography(std::span<const PlanePair> pairs) {
    constexpr int kDraws = 60;
    constexpr double kReach = 6.0;  ///< medians
    const auto distances = [&](const Eigen::Matrix3d& h) {
        std::vector<double> out;
        for (const PlanePair& p : pairs) {
            const Eigen::Vector3d at = h * p.board.homogeneous();
            out.push_back((at.hnormalized() - p.seen).norm());
        }
        return out;
    };
    const auto median = [](std::vector<double> values) {
        const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::nth_element(values.begin(), middle, values.end());
        return *middle;
    };
    auto best = homography_of(pairs);
    if (!best || pairs.size() < 8) {
        return best;
    }
    std::vector<double> off = distances(*best);
    double least = median(off);
    if (*std::ranges::max_element(off) < kReach * least) {
        return best;
    }
    std::uint32_t state = 12345;  // the same draws each time
    const auto draw = [&] {
        state = state * 1664525U + 1013904223U;
        return static_cast<std::size_t>(state >> 8U) % pairs.size();
    };
    for (int k = 0; k < kDraws; ++k) {
        const std::array<PlanePair, 4> four{pairs[draw()], pairs[draw()], pairs[draw()], pairs[draw()]};
        if (const auto h = homography_of(four)) {
            const double middle = median(distances(*h));
            if (middle < least) {
                least = middle;
                best = h;
            }
        }
    }
    off = distances(*best);
    std::vector<PlanePair> near;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (off[i] < kReach * least) {
            near.push_back(pairs[i]);
        }
    }
    const auto refined = homography_of(near);
    return refined ? refined : best;
}

Motion motion_of(const Eigen::Matrix3d& homography) {
    const double scale = 2.0 / (homography.col(0).norm() + homography.col(1).norm());
    const double sign = homography(2, 2) < 0.0 ? -1.0 : 1.0;
    const Eigen::Matrix3d h = sign * scale * homography;
    Eigen::Matrix3d turn;
    turn << h.col(0), h.col(1), h.col(0).cross(h.col(1));
    return {nearest_turn(turn), h.col(2)};
}

}  // namespace sc::host
