// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "firmware/motion/mark_stretches.hpp"
#include "firmware/motion/path_ends.hpp"
#include "firmware/trajectory/planner.hpp"
#include "firmware/trajectory/retimer.hpp"

/// The motion along one path: points in; where the beam is, over path time, out.
///
/// The nominal trajectory (firmware/trajectory) is a function of the points alone. It is run by a law of legs: nominal
/// at an even rate, or re-timed on the same path (hold, resume, a new override, starvation). Axes keep their limits in
/// each.
///
/// Two contexts. The servo step adds points, asks for stops and resumes, calls tick() once, and reads. work() is the
/// plan step, pre-emptible, counted in units: tick() grants kUnitsPerTick, and all that can be done with them must be
/// done before the next tick(), which publishes what was made. So what is planned, and when it takes effect, never
/// depends on how fast the board is.

namespace sc::motion {

using trajectory::AxisLimits;
using trajectory::Piece;
using trajectory::Place;

inline constexpr std::uint32_t kPointsPerTick = 8;  ///< that are taken
/// Units of planning a tick; a unit is one step of one cell, or one point.
inline constexpr std::uint32_t kUnitsPerTick = 30;

/// A stretch of path time on one polynomial. What is read for each frame and each pulse comes from here: no look-up, no
/// division, no root, no comparison. Valid until the next tick().
struct Segment {
    const Piece* piece = nullptr;
    double begin = 0.0;  ///< path time
    double end = 0.0;    ///< 1e30 beyond the law's end
    double t0 = 0.0;
    double x0 = 0.0;
    double rate = 0.0;  ///< 0 where it rests
    bool moving = false;

    /// Argument of the piece's polynomials at path time t, begin ≤ t ≤ end.
    [[nodiscard]] double x(double t) const noexcept { return x0 + (t - t0) * rate; }
};

/// Where a reader is; a default one finds its place by itself.
struct Cursor {
    std::uint32_t leg = 0;
    std::uint32_t piece = 0;
};

class PathMotion {
public:
    PathMotion() noexcept;

    /// Begins a path (servo context); the one before is dropped. False: the spec is refused.
    [[nodiscard]] bool open(const trajectory::Spec& spec) noexcept;
    /// Point and end of the path, only while `wants_points()`.
    void add(const Place& point, std::uint32_t item) noexcept { take({.place = point, .item = item}); }
    /// A circular arc from the last point through `via` to `to`; not the first. See trajectory::Planner::add_arc.
    void add_arc(const Place& via, const Place& to, std::uint32_t item) noexcept {
        take({.place = to, .item = item, .arc = true, .via = via});
    }
    /// The path goes dark at the last point, or the light comes back there. Only while `wants_lights()`; in turns.
    void add_light(const Place& place, const Place& arrives, std::uint32_t item) noexcept {
        marks_.add(place, arrives, item);
    }
    [[nodiscard]] bool wants_lights() const noexcept { return marks_.room(); }
    /// Nothing more is given until something of the path is done with: no want of points, then.
    void hold_back(bool full) noexcept { full_ = full; }
    void finish() noexcept;
    [[nodiscard]] bool wants_points() const noexcept;
    /// The path has ended without two distinct points, or a point was refused.
    [[nodiscard]] bool too_short() const noexcept { return bad_; }

    /// Two distinct points are known, so start() is: where the run-in begins.
    [[nodiscard]] bool has_start() const noexcept { return ends_.has_start(); }
    [[nodiscard]] const Place& start() const noexcept { return ends_.start(); }
    /// The last point has come, so last() is: where the run-out ends.
    [[nodiscard]] bool has_last() const noexcept { return ends_.finished(); }
    [[nodiscard]] const Place& last() const noexcept { return ends_.last(); }

    /// Once a tick, servo context: publishes what was made, then decides what is next. `path_time` is the time that
    /// this tick's set-points begin at; 0 until the path has begun. False: the plan step did not get through its work
    /// (Fault::planner_late).
    [[nodiscard]] bool tick(double path_time, double tick_seconds) noexcept;
    /// The plan step: up to `units` of work, never more than was granted.
    void work(std::uint32_t units) noexcept;

    /// Asks for a stop on the path; `stopped()` once the law ends at rest.
    void request_stop() noexcept;
    /// From rest: back up dark by the run-in before `distance` (true distance of the next pulse), then on.
    void request_resume(double distance) noexcept;
    /// Speed of the path as a share of the programmed one, 0.1 … 2. Above what the path was opened with, it is reached
    /// where the axes' limits leave room.
    void set_override(double share) noexcept { override_ = share; }

    /// The path may begin: enough is planned that a stop can be planned at any later moment, or all is.
    [[nodiscard]] bool ready() const noexcept;
    /// A stop was begun for want of points. Cleared by a resume.
    [[nodiscard]] bool starved() const noexcept { return starved_; }
    /// After a stop: what is known suffices to go on.
    [[nodiscard]] bool can_continue() const noexcept { return stopped() && ready(); }
    /// All of a finished path is planned, and the law runs to its end.
    [[nodiscard]] bool complete() const noexcept { return complete_ && !rests_; }
    /// The law ends at rest before the path's end, and no resume is under way.
    [[nodiscard]] bool stopped() const noexcept { return rests_ && !resume_wanted_; }
    /// Path time at which the law ends, once complete() or stopped().
    [[nodiscard]] double end_time() const noexcept;
    /// Path time from which the law moves forward again after a resume; pulses before it are withheld.
    [[nodiscard]] double rearm_time() const noexcept { return rearm_time_; }
    /// Pulses from this path time on are withheld: a stop begins. 1e30 otherwise.
    [[nodiscard]] double stop_time() const noexcept { return stop_time_; }
    /// Number of items below which everything is planned.
    [[nodiscard]] std::uint32_t planned_item() const noexcept;
    /// Share of the nominal speed at which the newest leg runs.
    [[nodiscard]] double rate() const noexcept { return rate_; }

    /// True distance from the start of the run-in at which marking begins.
    [[nodiscard]] double mark_begin() const noexcept { return ends_.run_in(); }
    /// … and up to which it goes for certain; where it ends, once the path is planned to its end.
    [[nodiscard]] double mark_end() const noexcept { return planned_distance_ - ends_.run_out(); }
    [[nodiscard]] bool end_known() const noexcept { return complete_; }
    /// A marked stretch, numbered from 0; none if it is not known yet where it begins. Those before forget_before's
    /// distance are forgotten.
    [[nodiscard]] std::optional<Stretch> stretch(std::uint32_t number) const noexcept;
    /// Whether a distance lies in a marked stretch.
    [[nodiscard]] bool marked(double distance) const noexcept;
    /// Longest run-in or run-out that this path can have, until it is finished.
    [[nodiscard]] double longest_run() const noexcept { return ends_.run_out(); }

    /// Law about path time t. Only after ready().
    [[nodiscard]] Segment segment(double t, Cursor& cursor) const noexcept;
    /// The same for t ≥ before.end, where `before` is what the same cursor gave last: cheap if it is the next piece.
    [[nodiscard]] Segment segment_after(const Segment& before, double t, Cursor& cursor) const noexcept;
    /// Nothing before path time t is read any more, and a resume will be from `distance` or beyond.
    void forget_before(double t, double distance) noexcept;

    /// For prints of the state.
    [[nodiscard]] const trajectory::Planner& planner() const noexcept { return planner_; }
    [[nodiscard]] const trajectory::Ring<Piece>& made() const noexcept { return made_; }
    [[nodiscard]] std::uint32_t legs() const noexcept { return leg_end_ - leg_first_; }

private:
    /// A stretch of path time.
    struct Leg {
        double begin = 0.0;
        double end = 1e30;  ///< kOpenEnd or beyond: it goes on
        bool nominal = true;
        bool backward = false;
        double u0 = 0.0;  ///< nominal time at its begin
        double rate = 1.0;
        double slowness = 1.0;    ///< 1 / rate
        std::uint32_t first = 0;  ///< pieces of a re-timed leg
        std::uint32_t last = 0;
    };
    enum class Task : std::uint8_t { none, stop, rate, lift, back, go };

    /// Spans that are tried for a change of rate, in shortest stops: the shorter ones fail where the nominal trajectory
    /// itself takes all that the limits give.
    static constexpr std::array<double, 7> kSpans{1.0, 1.3, 1.7, 2.3, 3.2, 4.5, 6.5};
    static constexpr double kOpenEnd = 1e29;       ///< s
    static constexpr std::uint32_t kTooMany = 96;  ///< pieces in a change
    static constexpr std::uint32_t kLegs = 8;
    static constexpr std::uint32_t kVertices = 1024;
    static constexpr std::uint32_t kNodes = 256;
    static constexpr std::uint32_t kPieces = 1024;
    static constexpr std::uint32_t kMade = 256;

    [[nodiscard]] const Leg& leg(std::uint32_t i) const noexcept { return legs_[i % kLegs]; }
    [[nodiscard]] Leg& leg(std::uint32_t i) noexcept { return legs_[i % kLegs]; }
    [[nodiscard]] const Leg& newest() const noexcept { return leg(leg_end_ - 1); }
    void take(const PathEnds::Point& point) noexcept;
    [[nodiscard]] bool give_on(std::uint32_t& units) noexcept;
    void push(const Leg& added) noexcept;
    /// For more of the path than there is.
    [[nodiscard]] bool no_room() const noexcept {
        return full_ || planner_.pieces().free() < trajectory::kPiecesAtOnce;
    }
    void take_points(std::uint32_t& units) noexcept;
    void choose() noexcept;
    void watch_supply() noexcept;
    void begin_lift() noexcept;
    [[nodiscard]] double place_change(double span, std::uint32_t most_pieces, trajectory::RateChange& change) noexcept;
    void choose_at_rest() noexcept;
    void begin_moving_task(Task task) noexcept;
    /// The ladder of spans begins anew for another task.
    void climb_for(Task task) noexcept {
        step_ = ladder_ == task ? step_ : 0;
        ladder_ = task;
    }
    void begin_change(Task task, const trajectory::RateChange& change) noexcept;
    void publish() noexcept;
    void give_up() noexcept;
    void drop_task() noexcept;
    void go_on(double begin) noexcept;
    void begin_back() noexcept;
    void begin_go() noexcept;
    [[nodiscard]] double wanted_rate() const noexcept;
    [[nodiscard]] double wanted_lift() const noexcept;
    [[nodiscard]] bool ran_out() const noexcept;
    void rest_at_end() noexcept;
    [[nodiscard]] double nominal_end() const noexcept;
    [[nodiscard]] double nominal_at(double t) const noexcept;
    [[nodiscard]] std::uint32_t leg_at(double t, std::uint32_t i) const noexcept;
    [[nodiscard]] double nominal_now() const noexcept;
    [[nodiscard]] std::uint32_t piece_at(double u) const noexcept;
    [[nodiscard]] double time_at_distance(double distance) const noexcept;
    [[nodiscard]] std::uint32_t pieces_between(std::uint32_t from, double until) const noexcept;

    std::array<PathEnds::Point, kPointsPerTick> pending_{};
    std::uint32_t pending_size_ = 0;
    std::uint32_t pending_taken_ = 0;
    bool end_pending_ = false;
    bool last_pending_ = false;  ///< the run-out is being given on
    bool bad_ = false;
    bool open_ = false;
    std::uint32_t credit_ = 0;
    bool idle_ = true;  ///< nothing more can be done until the next tick

    PathEnds ends_;
    MarkStretches marks_;
    double newest_distance_ = 0.0;  ///< at which the newest piece begins
    bool full_ = false;
    PathEnds::Points given_;  ///< by it, and not yet taken by the planner
    std::uint32_t given_taken_ = 0;
    trajectory::Retimer retimer_;
    std::array<trajectory::Vertex, kVertices> vertex_memory_;
    std::array<trajectory::Node, kNodes> node_memory_;
    std::array<Piece, kPieces> piece_memory_;
    std::array<Piece, kMade> made_memory_;
    trajectory::Planner planner_;
    trajectory::Ring<Piece> made_;

    std::array<Leg, kLegs> legs_{};
    std::uint32_t leg_first_ = 0;
    std::uint32_t leg_end_ = 0;

    double now_ = 0.0;  ///< path time of this tick
    double tick_s_ = 0.0;
    double override_ = 1.0;
    double rate_ = 1.0;           ///< of the newest nominal leg
    double planned_speed_ = 1.0;  ///< of the nominal trajectory, in programmed speeds
    double stop_span_ = 0.0;      ///< nominal time of the shortest stop
    double planned_distance_ = 0.0;
    std::uint32_t planned_end_ = 0;  ///< nominal pieces that are published
    bool stop_wanted_ = false;
    bool resume_wanted_ = false;
    bool starved_ = false;
    bool waits_ = false;         ///< the planner waited for points in the last tick
    bool complete_ = false;      ///< the nominal trajectory is planned to the path's end
    bool rests_ = false;         ///< the law ends at rest, now or later
    bool backed_ = false;        ///< for the resume that is under way
    bool back_reaches_ = false;  ///< the way back under way is the last of them
    double rest_u_ = 0.0;
    double stop_time_ = 1e30;
    double rearm_time_ = 0.0;
    double resume_distance_ = 0.0;

    Task task_ = Task::none;
    double task_begin_ = 0.0;  ///< path time at which a change from motion begins
    trajectory::RateChange change_;
    std::uint32_t step_ = 0;    ///< of the ladder of spans …
    Task ladder_ = Task::none;  ///< … of this task
    std::uint32_t missed_ = 0;  ///< times that a change was not ready in time
    double go_rate_ = 1.0;
    std::uint32_t made_begin_ = 0;
    /// States of the re-timed leg in force, so that another change can begin in its midst.
    std::array<trajectory::Rate, trajectory::Retimer::kNodes> rates_{};
    std::uint32_t rates_size_ = 0;
    double rates_begin_ = 0.0;
    double lift_ = 1.0;        ///< the greatest rate of the leg in force
    double lift_after_ = 0.0;  ///< path time before which no further lift is tried
};

}  // namespace sc::motion
