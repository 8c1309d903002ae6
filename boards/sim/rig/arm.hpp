// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "boards/sim/rig/rig_files.hpp"

/// A 6-axis arm by Denavit-Hartenberg parameters (Craig, Introduction to Robotics: a link turns by theta about z,
/// shifts by d along z and a along x, and turns by alpha about x). What a robot reports are its joint angles through
/// the parameters that its controller believes; where it stands follows from the true ones.

namespace sc::sim {

using Joints = std::array<double, 6>;  ///< radians

struct Arm {
    struct Link {
        double theta = 0.0;  ///< offset of the joint, radians
        double d = 0.0;      ///< metres
        double a = 0.0;
        double alpha = 0.0;
    };
    std::array<Link, 6> link;

    /// b_from_f.
    [[nodiscard]] Pose at(const Joints& joints) const;
    /// Joint angles that bring the flange there, near `start`; nothing where it cannot reach.
    [[nodiscard]] std::optional<Joints> reach(const Pose& b_from_f, const Joints& start) const;
};

/// An arm with a reach of some 1.5 m.
[[nodiscard]] Arm nominal_arm();
/// Each length off by `length`, each angle by `angle`, 1 sigma. With 0.28 mm and 0.028 degrees the flange is
/// some 0.35 mm off, with base and tool put where that is least.
[[nodiscard]] Arm with_errors(Arm arm, double length, double angle, Random& random);

}  // namespace sc::sim
