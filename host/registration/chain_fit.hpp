// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "host/calibration/motion.hpp"
#include "host/registration/chain_system.hpp"

/// The joint bundle itself: model, state and Levenberg-Marquardt. For chain.cpp. A pose takes a place in the frame of
/// what saw it (a view of the sensor; the scribing frame, for places pointed at) to c; a stop is where the turntable
/// stood. A marker stands still, or turns with the table; its place is that at C = 0.

namespace sc::host {

struct ChainSight {
    std::size_t pose = 0;
    std::size_t stop = 0;
    std::size_t marker = 0;
    Eigen::Vector3d place;   ///< as seen
    Eigen::Vector3d weight;  ///< 1/σ² of its coordinates
    bool used = true;
};
struct ChainRead {
    std::size_t pose = 0;
    Motion b_from_f;
};
struct ChainKnown {
    std::size_t marker = 0;
    Eigen::Vector3d place;  ///< in c
    double weight = 0.0;
};
struct ChainStop {
    double turn = 0.0;    ///< as read, radians
    double weight = 0.0;  ///< 1/σ²; 0: the reading is wrong
};
struct ChainModel {
    std::size_t poses = 0;
    std::vector<bool> turning;  ///< a marker each
    std::vector<ChainStop> stops;
    std::vector<ChainSight> sights;
    std::vector<ChainKnown> known;
    std::vector<ChainRead> reads;
    bool has_axis = false;
    double robot_turn = 0.0;  ///< 1 sigma
    double robot_place = 0.0;

    [[nodiscard]] Eigen::Index pose_at(std::size_t pose) const { return 6 * static_cast<Eigen::Index>(pose); }
    [[nodiscard]] Eigen::Index stop_at(std::size_t stop) const {
        return pose_at(poses) + static_cast<Eigen::Index>(stop);
    }
    [[nodiscard]] Eigen::Index axis_at() const { return stop_at(stops.size()); }
    [[nodiscard]] Eigen::Index robot_at() const { return axis_at() + (has_axis ? 4 : 0); }
    [[nodiscard]] Eigen::Index common() const { return robot_at() + (reads.empty() ? 0 : 12); }
};
struct ChainState {
    std::vector<Motion> pose;         ///< c_from_...
    std::vector<double> off;          ///< of each stop: true angle less reading
    std::vector<Eigen::Vector3d> at;  ///< markers in c, table at C = 0
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
    Eigen::Matrix<double, 3, 2> across = Eigen::Matrix<double, 3, 2>::Zero();
    Motion c_from_b;
    Motion f_from_s;
};

/// Two directions across `direction`, with it a right-handed frame.
[[nodiscard]] Eigen::Matrix<double, 3, 2> across_of(const Eigen::Vector3d& direction);
/// Place in c of a marker with the table at `turn` (radians).
[[nodiscard]] Eigen::Vector3d chain_place(const ChainState& state, bool turning, const Eigen::Vector3d& at,
                                          double turn);
/// Measured less predicted, metres.
[[nodiscard]] Eigen::Vector3d chain_residual(const ChainModel& model, const ChainState& state, const ChainSight& sight);
/// d predicted / d unknowns of a place seen from `pose` with the table at `turn`.
struct ChainSlope {
    std::vector<ChainSystem::Part> parts;  ///< pose; for a marker that turns: axis, then `stop`'s angle (if any)
    Eigen::Matrix3d own;
    Eigen::Vector3d by_turn = Eigen::Vector3d::Zero();  ///< metres per radian
};
[[nodiscard]] ChainSlope chain_slope(const ChainModel& model, const ChainState& state, std::size_t pose,
                                     std::size_t marker, double turn, std::optional<std::size_t> stop);
/// Turn and place, read less predicted, of a robot pose.
[[nodiscard]] Eigen::Matrix<double, 6, 1> read_residual(const ChainState& state, const ChainRead& read);

/// Moves `state` to the least sum of squares and returns that.
double fit_chain_state(const ChainModel& model, ChainState& state);
[[nodiscard]] ChainSystem::Spread chain_spread(const ChainModel& model, const ChainState& state);
/// How much larger (or smaller) the robot's noise is than the model's, from the scatter of its readings about the fit.
[[nodiscard]] double robot_ratio(const ChainModel& model, const ChainState& state, const ChainSystem::Spread& spread);

}  // namespace sc::host
