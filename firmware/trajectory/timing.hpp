// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/trajectory/polygon.hpp"
#include "firmware/trajectory/spec.hpp"

/// Third-order time-optimal timing of a curve q(s), cell by cell. In a cell q''' is constant and so is u = d²b/ds² with
/// b = ṡ². Then per axis
///
///     acceleration = q'' b + q' c / 2                      with c = db/ds
///     jerk         = (q''' b + 3/2 q'' c + 1/2 q' u) √b
///
/// The jerk limit |…| ≤ J / √b is made linear by the tangent of 1/√b at a guess b̂, which lies below it: every state
/// that keeps the tangent keeps the limit. Backward, the set of states (b, c) from which the end can be reached is a
/// convex polygon per node; forward, the greatest u that stays in the next set is taken.
///
/// A step backward: over each state of the next set the limits leave a range of u, whose ends are a concave and a
/// convex surface of planes. A state and a u give a state of this node, and all of them a convex set. Its hull is made
/// of both ends of the range at the corners of the next set, and where the limit that counts changes along its edges;
/// so it is never more than the true set, and less by what lies between.

namespace sc::trajectory {

/// Of the limits that a node's share and room are shares of: the rest is for what quintics over a cell add.
inline constexpr double kAccelerationShare = 0.998;
inline constexpr double kJerkShare = 0.988;

/// A node of the curve and the cell that begins there. s in scaled metres.
struct Node {
    double s = 0.0;
    double h = 0.0;  ///< length of the cell; 0 at the last node of a curve
    Place p{};
    Place d1{};
    Place d2{};
    Place d3{};
    double cap = 0.0;    ///< greatest b
    double guess = 0.0;  ///< b̂
    double share = 1.0;  ///< of the jerk limit to be used in the cell; lowered where a check found too much
    double room = 1.0;   ///< the same for acceleration, at the node
    double slack = 0.0;  ///< of these limits, so that a state planned before is not lost to rounding
    double b = 0.0;      ///< plan in force
    double c = 0.0;
    double trial_b = 0.0;
    double trial_c = 0.0;
    std::uint32_t item = 0;
    bool last = false;
    StoredPolygon set;  ///< states from which the end of the window can be reached
};

/// The bound on u that a limit gives at (b, c) is constant + by_b·b + by_c·c.
struct Bound {
    double constant = 0.0;
    double by_b = 0.0;
    double by_c = 0.0;
    [[nodiscard]] double at(double b, double c) const noexcept { return constant + by_b * b + by_c * c; }
};

/// Bounds that hold together: the least of them, or the greatest, counts.
struct Bounds {
    static constexpr std::uint32_t kCapacity = 6 * kAxisCount + 1 + StoredPolygon::kCapacity;
    std::uint32_t count = 0;
    std::array<Bound, kCapacity> each;
};

/// Scratch of a step, so that it is on no stack. Nothing in it outlives a call: one for all plans of a context.
struct Workspace {
    /// A state, with the range of u that it leaves.
    struct Corner : State {
        double high = 0.0;
        double low = 0.0;
        std::uint8_t above = 0;  ///< which bound `high` is
        std::uint8_t below = 0;
        bool known = false;
    };
    /// The next set.
    struct Corners {
        static constexpr std::uint32_t kCapacity = 16;
        std::uint32_t count = 0;
        std::array<Corner, kCapacity> each;

        void move(std::uint32_t to, std::uint32_t from) noexcept { each[to] = each[from]; }
        void put(std::uint32_t i, const State& state) noexcept { each[i] = {state}; }
        [[nodiscard]] const State& at(std::uint32_t i) const noexcept { return each[i]; }
    };
    /// Points of which a side of a convex hull is made.
    struct Chain {
        std::uint32_t count = 0;
        std::array<State, 22> at;
    };
    Bounds above;
    Bounds below;
    Corners corners;
    Chain points;
    Chain hull;
    Polygon set;
};

/// Units (planner.hpp) that a backward_step() counts as, and the check of a cell.
inline constexpr std::uint32_t kUnitsBackward = 3;
inline constexpr std::uint32_t kUnitsCheck = 2;

/// Set of `node` from that of `next`; what it leaves out is small. False if it is empty. Where the node has a slack,
/// its state of the plan in force stays in the set if possible. Cost: some 6 000 instructions, 12 000 at most.
[[nodiscard]] bool backward_step(const Limits& limits, Node& node, const Node& next, Workspace& workspace) noexcept;

/// From the trial state of `node` to that of `next`. False if no state with b > 0 is found. Cost: some 1 000
/// instructions.
[[nodiscard]] bool forward_step(const Limits& limits, const Node& node, Node& next, Workspace& workspace) noexcept;

/// Set of the states b = 0.75·length·|c| on a ramp of constant jerk to or from rest over `length`, up to `jerk`.
/// `slowing`: c < 0. Thin, because it is a line; the caller puts the state on the line.
[[nodiscard]] Polygon ramp_set(double length, double jerk, bool slowing) noexcept;

/// Limits of state at a node only: speed and acceleration.
void clip_state(const Limits& limits, const Node& node, Polygon& set) noexcept;

/// The greatest share of (b, c) that is still in the set, at most 1; negative if none.
[[nodiscard]] double reach(const StoredPolygon& set, double b, double c) noexcept;

}  // namespace sc::trajectory
