// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/trajectory/piece.hpp"
#include "firmware/trajectory/ring.hpp"
#include "firmware/trajectory/timing.hpp"

namespace sc::trajectory {

/// How nominal time u passes over real time at a moment of it.
struct Rate {
    double u = 0.0;
    double b = 0.0;  ///< (du/dt)² · speed², with the path speed of the limits; 0: at rest
    double c = 0.0;  ///< d²u/dt² · 2 · speed
    double t = 0.0;  ///< real time, s since the path's start
};

/// A change of the rate at which a nominal trajectory is run, over a stretch of it.
struct RateChange {
    enum class End : std::uint8_t {
        rest,  ///< du/dt = 0
        rate,  ///< du/dt = `rate`, not changing
        free,  ///< the nominal trajectory itself rests there
    };
    Rate from;
    double until = 0.0;       ///< nominal time; less than from.u runs backward, and then from rest
    std::uint32_t piece = 0;  ///< number of the nominal piece in which it begins, seen in the direction of running
    End end = End::rest;
    double rate = 1.0;  ///< 0 < rate ≤ 1: that of End::rate, and the greatest, but for `most`
    double most = 1.0;  ///< the greatest that a rise that is under way may come to, and all of a lifted stretch
    bool lifted = false;
};

/// Re-times a stretch of nominal trajectory: p(u(t)) with every axis within its speed, acceleration and jerk, from rest
/// or from any rate, on the same path. Nominal time takes the part that path length has elsewhere (timing.hpp):
/// q(u) is the curve, du/dt its speed; running at rate 1 is always one solution, whatever the trajectory. A lifted
/// stretch runs faster where the limits leave room: up to `most` times the nominal speed.
///
/// One attempt at one stretch; whether it is possible at all in so short a stretch is seen on the way. What is written
/// was checked on the polynomials that are written. No heap, no clock; plan context.
class Retimer {
public:
    static constexpr std::uint32_t kNodes = 128;
    static constexpr std::uint32_t kMostPieces = kNodes;

    enum class State : std::uint8_t { idle, build, backward, forward, check, write, done, failed };

    void begin(const RateChange& change) noexcept;
    /// One step; returns the units of work that it counts as. `nominal` must hold the whole stretch; `made` must have
    /// room for kMostPieces. Pieces of `made` hold real time in `start`.
    std::uint32_t step(const Limits& limits, const Ring<Piece>& nominal, Ring<Piece>& made) noexcept;
    void drop() noexcept { state_ = State::idle; }

    [[nodiscard]] State state() const noexcept { return state_; }
    [[nodiscard]] bool working() const noexcept {
        return state_ != State::idle && state_ != State::done && state_ != State::failed;
    }
    /// Where the rate stands at each cell's beginning and, last, at the end; once done.
    [[nodiscard]] std::uint32_t count() const noexcept { return count_; }
    [[nodiscard]] const Rate& at(std::uint32_t i) const noexcept { return rates_[i]; }
    /// Units that an attempt over `pieces` nominal pieces takes, if no check fails.
    [[nodiscard]] static std::uint32_t units(std::uint32_t pieces) noexcept;

private:
    void build(const Limits& limits, const Ring<Piece>& nominal) noexcept;
    void finish_node(const Limits& limits, const Piece& piece, double begin, double end, Node& node,
                     const Node& next) noexcept;
    void begin_backward(const Limits& limits) noexcept;
    void guess(const Limits& limits) noexcept;
    void backward(const Limits& limits) noexcept;
    void forward(const Limits& limits) noexcept;
    void check(const Limits& limits, const Ring<Piece>& nominal) noexcept;
    void again(const Limits& limits) noexcept;
    void write(const Limits& limits, const Ring<Piece>& nominal, Ring<Piece>& made) noexcept;
    [[nodiscard]] Motion travel(const Limits& limits, const Piece& piece, double u, double b, double c) const noexcept;
    [[nodiscard]] Node& node(std::uint32_t i) noexcept { return nodes_[i]; }

    RateChange change_;
    State state_ = State::idle;
    double sign_ = 1.0;
    double longest_ = 0.0;      ///< cell, in nominal time
    double fastest_ = 0.0;      ///< along the path, m/s
    std::uint32_t piece_ = 0;   ///< that the next node is made from
    std::uint32_t count_ = 0;   ///< nodes
    std::uint32_t first_ = 0;   ///< node that the plan begins at: behind the ramp from rest
    std::uint32_t target_ = 0;  ///< node that it aims at: before the ramp to rest
    std::uint32_t cursor_ = 0;
    std::uint32_t tries_ = 0;
    bool good_ = false;
    double begin_share_ = 1.0;  ///< of the jerk of the ramps at both ends
    double end_share_ = 1.0;
    double begin_jerk_ = 0.0;
    double end_jerk_ = 0.0;
    std::array<Node, kNodes> nodes_;
    std::array<Rate, kNodes> rates_;
    std::array<std::uint32_t, kNodes> source_{};  ///< piece of each cell
    Workspace workspace_;
};

}  // namespace sc::trajectory
