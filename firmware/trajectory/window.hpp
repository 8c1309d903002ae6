// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/trajectory/ring.hpp"
#include "firmware/trajectory/timing.hpp"
#include "firmware/trajectory/trajectory_writer.hpp"

namespace sc::trajectory {

/// Counters for tests and benches.
struct WindowCounts {
    std::uint32_t plans = 0;      ///< plans accepted
    std::uint32_t passes = 0;     ///< backward and forward passes
    std::uint32_t continued = 0;  ///< a plan was not accepted, the one before went on
    std::uint32_t stretched = 0;  ///< a plan from rest was slowed as a whole
    std::uint32_t crawled = 0;    ///< cells passed from rest to rest, for want of any plan
    std::uint32_t cells = 0;      ///< cells written
};

/// Times the curve of one run, window by window: each plan ends at rest, at the window's end or at the run's. Every
/// plan is checked cell by cell on the very polynomials that are written; one that breaks a limit is made again with
/// less room where it did. If that fails the plan in force goes on (it was checked up to its own rest), and from rest
/// the whole plan is stretched in time. So what is written keeps the limits whatever the curve.
///
/// Work is counted in units: a cell is one in each pass, and kUnitsBackward in the pass backward.
class WindowPlanner {
public:
    /// A run whose first node comes next into `nodes`. `ramp` is the length in s of the ramp before it.
    void start(const Ring<Node>& nodes, const Place& corner, const Joint& joint, double ramp,
               std::uint32_t item) noexcept;
    void set_end(const Place& corner, const Joint& joint, double ramp) noexcept;

    /// Up to one pass or one piece; the units that it took, 0 if it waits for nodes or for room.
    [[nodiscard]] std::uint32_t step(const Limits& limits, Ring<Node>& nodes, TrajectoryWriter& writer) noexcept;
    /// The run is written up to its end.
    [[nodiscard]] bool done() const noexcept { return done_; }
    [[nodiscard]] const WindowCounts& counts() const noexcept { return counts_; }
    void clear_counts() noexcept { counts_ = {}; }

private:
    enum class Stage : std::uint8_t { wait, guess_up, guess_down, backward, forward, check, write };
    struct End {
        Place corner{};
        Joint joint;
        double ramp = 0.0;
    };

    [[nodiscard]] bool find_window(const Limits& limits, const Ring<Node>& nodes) noexcept;
    [[nodiscard]] std::uint32_t choose_rest(const Limits& limits, const Ring<Node>& nodes) noexcept;
    [[nodiscard]] std::uint32_t begin_plan(const Limits& limits, Ring<Node>& nodes) noexcept;
    void begin_guess() noexcept;
    void guess_up(const Limits& limits, Ring<Node>& nodes) noexcept;
    void guess_down(const Limits& limits, Ring<Node>& nodes) noexcept;
    void trust_plan_in_force(Ring<Node>& nodes) noexcept;
    void backward(const Limits& limits, Ring<Node>& nodes) noexcept;
    void begin_forward(Ring<Node>& nodes) noexcept;
    void forward(const Limits& limits, Ring<Node>& nodes) noexcept;
    void check(const Limits& limits, Ring<Node>& nodes) noexcept;
    void judge(const Limits& limits, Ring<Node>& nodes) noexcept;
    void again(const Limits& limits, Ring<Node>& nodes) noexcept;
    void level_guess(Ring<Node>& nodes) const noexcept;
    void give_up(Ring<Node>& nodes) noexcept;
    void accept(const Limits& limits, Ring<Node>& nodes, double stretch) noexcept;
    void commit_to(const Ring<Node>& nodes, double length) noexcept;
    void write(const Limits& limits, Ring<Node>& nodes, TrajectoryWriter& writer) noexcept;
    void crawl_cell(const Limits& limits, const Node& cell, TrajectoryWriter& writer) noexcept;
    void crawl(const Limits& limits, const Place& from, const Place& to, TrajectoryWriter& writer,
               std::uint32_t item) noexcept;
    /// Looks at one cell of a trial; returns its greatest speed, of the limit, if that alone is at fault.
    [[nodiscard]] double note(const Limits& limits, const Node& from, const Node& to, double b0, double c0, double b1,
                              double c1, double& share, double& room0, double& room1) noexcept;

    End begin_{};
    End end_{};
    std::uint32_t item_ = 0;
    bool done_ = false;
    bool fresh_ = false;    ///< nothing of the run is written yet: the ramp from its corner comes first
    bool resting_ = false;  ///< the plan begins from rest
    Stage stage_ = Stage::wait;

    std::uint32_t base_ = 0;    ///< node at which the plan begins moving
    std::uint32_t looked_ = 0;  ///< nodes below, from base_ on, do not end the window
    std::uint32_t window_ = 0;  ///< last node of the window
    std::uint32_t target_ = 0;  ///< node at which the ramp to rest begins
    bool to_end_ = false;       ///< the window reaches the run's end
    double start_length_ = 0.0;
    double start_jerk_ = 0.0;
    double target_length_ = 0.0;
    double target_jerk_ = 0.0;

    bool in_force_ = false;  ///< a plan from base_ is in force
    std::uint32_t force_target_ = 0;
    std::uint32_t force_window_ = 0;
    bool force_to_end_ = false;

    std::uint32_t cursor_ = 0;
    double guess_ = 0.0;  ///< b at the cursor
    std::uint32_t tries_ = 0;
    bool sound_ = false;  ///< the trial has states everywhere
    bool good_ = false;
    bool crooked_ = false;  ///< it leaves the curve
    bool strayed_ = false;  ///< a trial of the plan did
    double worst_ = 0.0;    ///< stretch that would cure the trial
    double start_share_ = 1.0;
    double target_share_ = 1.0;
    std::uint32_t commit_ = 0;
    bool crawling_ = false;
    WindowCounts counts_;
    Workspace workspace_;
};

}  // namespace sc::trajectory
