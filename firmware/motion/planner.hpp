// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/motion/path_builder.hpp"
#include "firmware/motion/time_law.hpp"
#include "shared/math/scalar.hpp"

/// Look-ahead planner of one path: elements in, time law out.
///
/// Two contexts. The servo step adds points, asks for a stop or a resume, and reads published pieces. `work()` is the
/// plan step: pre-emptible, counted in units. A task begun at tick n is published by the servo step at tick n +
/// kPublishTicks and not before, whatever the board's speed: what is planned, and when it takes effect, never depends
/// on how fast the board is.
///
/// The plan is a function of the points alone: batches of kBatch elements, each planned to come to rest kHorizon
/// elements further on (or at the path's end). A batch waits until these elements, or the end, are known.

namespace sc::motion {

inline constexpr std::uint32_t kBatch = 64;
inline constexpr std::uint32_t kHorizon = 384;
inline constexpr std::uint32_t kHistory = 128;  ///< passed elements kept for backing up
inline constexpr std::int64_t kPublishTicks = 4;
inline constexpr std::uint32_t kPointsPerTick = 8;  ///< that the planner takes
/// Units of work. One is an element of the backward pass, some 220 instructions on a Cortex-M7.
inline constexpr std::uint32_t kUnitsPerPoint = 10;   ///< to build its elements
inline constexpr std::uint32_t kUnitsPerElement = 3;  ///< of the forward pass
/// What a board must get through per tick: the points of a tick, a quarter of a task, and what a step left over.
inline constexpr std::uint32_t kUnitsPerTick = kPointsPerTick * kUnitsPerPoint +
                                               (kBatch + kHorizon + kBatch * kUnitsPerElement) / kPublishTicks +
                                               kUnitsPerElement;

/// Where the law stands at a path time.
struct MotionState {
    double tau = 0.0;
    double speed = 0.0;
    double acceleration = 0.0;
    std::uint32_t element = 0;
    std::uint32_t piece = 0;
};

/// A stretch of path time in which the law is one cubic and the beam on one element. What is read for each frame and
/// each pulse comes from here: no look-up, no division, no root, no comparison. Valid until the planner's next tick().
struct Segment {
    double begin = 0.0;  ///< path time; −1e30 before the law begins
    double end = 0.0;    ///< 1e30 beyond the law's end
    bool moving = false;
    double t0 = 0.0;  ///< way(t) = way0 + dt (v0 + dt (a0/2 + dt j/6)) with dt = t − t0
    double way0 = 0.0;
    double v0 = 0.0;
    double a0_half = 0.0;
    double j_sixth = 0.0;
    const Element* element = nullptr;

    /// Way on the element, 0 … length but for rounding, begin ≤ t ≤ end.
    [[nodiscard]] double way(double t) const noexcept {
        const double dt = t - t0;
        return way0 + dt * (v0 + dt * (a0_half + dt * j_sixth));
    }
    /// d(way)/dt.
    [[nodiscard]] double speed(double t) const noexcept {
        const double dt = t - t0;
        return v0 + dt * (2.0 * a0_half + dt * (3.0 * j_sixth));
    }
};

class Planner {
public:
    /// Begins a path (servo context). Drops the one before.
    void open(const PathSpec& spec) noexcept;
    /// Point and end of the path, servo context, only while `wants_points()`. They are kept; the next work() makes
    /// elements of them, and the next tick() sees those.
    void add(const Place& point, std::uint32_t item) noexcept;
    void finish() noexcept { end_pending_ = true; }
    /// Room for another point, and the path is still open.
    [[nodiscard]] bool wants_points() const noexcept;
    /// The path has ended without two distinct points.
    [[nodiscard]] bool too_short() const noexcept { return too_short_; }

    /// Once a tick, servo context: publishes a task that is due, then begins the next. `path_time` is the time that
    /// this tick's set-points begin at. False: a task was due and not finished, or a point is still without its
    /// elements (Fault::planner_late).
    [[nodiscard]] bool tick(std::int64_t tick, double path_time, double tick_seconds) noexcept;
    /// The plan step: up to `units` of work.
    void work(std::uint32_t units) noexcept;

    /// Asks for a jerk-limited stop on the path as soon as a task can be published; `stop_done()` once the law ends at
    /// rest.
    void request_stop() noexcept { stop_wanted_ = true; }
    /// From rest: back up dark to where `distance` (true distance of the next pulse) can be reached at speed, then on.
    void request_resume(double distance) noexcept;

    [[nodiscard]] const ElementRing& elements() const noexcept { return ring_; }
    [[nodiscard]] const TimeLaw& law() const noexcept { return law_; }
    [[nodiscard]] const PathBuilder& builder() const noexcept { return builder_; }
    /// The path may begin: enough is planned that a stop can be planned and published at any later moment, or all is.
    [[nodiscard]] bool ready(double tick_seconds) const noexcept;
    /// The planner itself has begun a stop, because points do not arrive fast enough. Cleared by a resume.
    [[nodiscard]] bool starved() const noexcept { return starved_; }
    /// After a stop: what is known suffices to go on.
    [[nodiscard]] bool can_continue() const noexcept;
    /// All of a finished path is planned and published.
    [[nodiscard]] bool complete() const noexcept;
    /// Published law ends at rest before the path's end, by request.
    [[nodiscard]] bool stopped() const noexcept { return stopped_; }
    /// Path time from which the law moves forward again after a resume; pulses before it are withheld.
    [[nodiscard]] double rearm_time() const noexcept { return rearm_time_; }
    /// A stop takes effect at this path time (valid once published); infinite while none is asked for.
    [[nodiscard]] double stop_time() const noexcept { return stop_time_; }
    /// Number of items below which everything is planned.
    [[nodiscard]] std::uint32_t planned_item() const noexcept;

    /// Published law at path time t. `hint` remembers the piece between calls.
    [[nodiscard]] MotionState state(double t, std::uint32_t& hint) const noexcept;
    [[nodiscard]] Place place(const MotionState& state) const noexcept {
        return ring_.at(state.element).place(state.tau);
    }
    /// Published law about path time t, of a path that is ready(). `hint` remembers the piece between calls.
    [[nodiscard]] Segment segment(double t, std::uint32_t& hint) const noexcept;
    /// Forget what no reader needs any more: everything before path time t.
    void forget_before(double t) noexcept;

private:
    enum class Task : std::uint8_t { none, plan, stop, resume };
    enum class Stage : std::uint8_t { backward, forward, done };
    /// One element, or the part of it that is to be run, in the direction of running.
    struct Span {
        std::uint32_t element = 0;
        double from = 0.0;
        double length = 0.0;
        double cap = 0.0;
        TangentLimits limits;
        bool blend = false;
        bool stop_after = false;
    };

    void build(std::uint32_t& units) noexcept;
    [[nodiscard]] bool plannable() const noexcept;
    [[nodiscard]] bool enough_known() const noexcept;
    void choose_task(double path_time, double tick_seconds) noexcept;
    void begin_plan() noexcept;
    void step_backward() noexcept;
    void step_forward() noexcept;
    void plan_stop() noexcept;
    void plan_resume() noexcept;
    void publish() noexcept;
    [[nodiscard]] Span forward_span(std::uint32_t element, double from) const noexcept;
    [[nodiscard]] Span reverse_span(std::uint32_t element, double from, double to) const noexcept;
    /// Appends the pieces of one span from v0 to v1; `sign` −1 runs backward. Advances `time`.
    void append_span(const Span& span, double v0, double v1, double sign, double& time) noexcept;
    void append(const Piece& piece) noexcept;
    [[nodiscard]] double back_up_to(double distance, std::uint32_t& element) const noexcept;
    void run_back(double tau_rest, std::uint32_t element_rest, double tau_back, std::uint32_t element_back,
                  double& time) noexcept;

    struct Point {
        Place place{};
        std::uint32_t item = 0;
    };
    std::array<Point, kPointsPerTick> pending_{};
    std::uint32_t pending_size_ = 0;
    std::uint32_t built_ = 0;  ///< of those pending
    bool end_pending_ = false;
    bool too_short_ = false;
    PathBuilder builder_;
    ElementRing ring_;
    TimeLaw law_;

    Task task_ = Task::none;
    Stage stage_ = Stage::done;
    std::int64_t publish_tick_ = 0;
    bool stop_wanted_ = false;
    bool resume_wanted_ = false;
    bool stopped_ = false;
    bool starved_ = false;
    double stop_time_ = 1e30;
    double rearm_time_ = 0.0;
    double resume_distance_ = 0.0;

    // Planning cursor: the next element to be given a law, from where, at what speed and time.
    std::uint32_t next_ = 0;
    double next_tau_ = 0.0;
    double next_speed_ = 0.0;
    double next_time_ = 0.0;
    std::uint32_t commit_end_ = 0;
    std::uint32_t window_end_ = 0;
    std::uint32_t cursor_ = 0;
    std::array<double, ElementRing::kCapacity> entry_speed_{};  ///< by element number modulo capacity

    // Result of a stop or resume task until it is published.
    double cut_time_ = 0.0;
    bool overflow_ = false;
    static constexpr std::size_t kSpliceCapacity = 1024;
    std::array<Piece, kSpliceCapacity> splice_{};
    std::size_t splice_size_ = 0;
    bool to_splice_ = false;
    double rearm_after_publish_ = 0.0;
    bool rests_after_publish_ = false;
    static constexpr std::size_t kBackCapacity = 256;
    std::array<Span, kBackCapacity> back_{};
    std::array<double, kBackCapacity + 1> back_speed_{};
};

}  // namespace sc::motion
