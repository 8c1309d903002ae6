// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <expected>
#include <span>

#include "firmware/trajectory/arc.hpp"
#include "firmware/trajectory/line.hpp"
#include "firmware/trajectory/piece.hpp"
#include "firmware/trajectory/polyline.hpp"
#include "firmware/trajectory/spec.hpp"
#include "firmware/trajectory/spline.hpp"
#include "firmware/trajectory/trajectory_writer.hpp"
#include "firmware/trajectory/window.hpp"

namespace sc::trajectory {

/// Memory of a planner, given by its owner. Sizes are powers of two.
struct Storage {
    std::span<Vertex> points;  ///< at least 1024
    std::span<Node> nodes;     ///< at least 256
    std::span<Piece> pieces;   ///< at least 64; what is planned and not yet read
};

/// A near-time-optimal trajectory along a polyline, from rest to rest, within a tolerance of it, with speed,
/// acceleration and jerk of every axis within their limits at every moment.
///
/// Between corners (turns of more than 45°) the path is one smooth curve or one straight line. A straight line between
/// two corners is passed in closed form; a curve by time-optimal path parametrisation over a look-ahead of three
/// braking distances. At a corner the two runs overlap as far as the tolerance allows.
///
/// The trajectory is a function of the points alone: how add(), work() and the reading of pieces interleave changes
/// nothing. Nominal time begins at 0; hold, resume and override are laws of nominal time over real time and no business
/// of this class. Not re-entrant: one context. No heap, no clock.
class Planner {
public:
    explicit Planner(const Storage& storage) noexcept;

    /// Begins a path; the one before is dropped.
    [[nodiscard]] std::expected<void, Refusal> open(const Spec& spec) noexcept;
    /// Next point; `item` must not fall. Points closer than a fifth of the tolerance (2 µm at most) to the last kept
    /// one are left out. Cost: some 50 operations.
    [[nodiscard]] std::expected<void, Refusal> add(const Place& point, std::uint32_t item) noexcept;
    /// A circular arc over x, y, z from the last point through `via` to `to`, C turning evenly; it counts as one point.
    /// A whole circle is two arcs. The path stays within the tolerance of the true arc, of which kArcShare is for the
    /// chords that it is run as. One that is straight within that share is run as a line. Its chords are made by
    /// work(), and until the last of them is there no other point is taken. Cost: some 600 operations.
    [[nodiscard]] std::expected<void, Refusal> add_arc(const Place& via, const Place& to, std::uint32_t item) noexcept;
    /// No more points.
    [[nodiscard]] std::expected<void, Refusal> finish() noexcept;
    /// There is room for another point. Needs work() and reading of pieces if not.
    [[nodiscard]] bool wants_points() const noexcept {
        return open_ && !finished_ && arc_.left() == 0 && points_.free() > 0;
    }

    /// Works for `units`, and up to 3 more to end what it is at; returns those used, fewer if it waits for points or
    /// for room. A unit is 2 000 to 4 000 instructions of a Cortex-M7 in the mean and 7 200 at most, in what was
    /// measured: a vertex, a knot, or a cell in one pass is one, a cell in the pass backward is 3, a line is 4.
    std::uint32_t work(std::uint32_t units) noexcept;

    /// Pieces that are ready, oldest first.
    [[nodiscard]] std::uint32_t ready() const noexcept { return writer_.pieces().size(); }
    [[nodiscard]] const Piece& front() const noexcept { return writer_.pieces()[writer_.pieces().first()]; }
    void pop() noexcept { writer_.pieces().forget_before(writer_.pieces().first() + 1); }
    /// The same by number, for a reader that looks back and ahead.
    [[nodiscard]] const Ring<Piece>& pieces() const noexcept { return writer_.pieces(); }
    [[nodiscard]] Ring<Piece>& pieces() noexcept { return writer_.pieces(); }
    /// All of a finished path is in pieces (which may still wait to be read).
    [[nodiscard]] bool complete() const noexcept { return stage_ == Stage::complete; }

    [[nodiscard]] const Limits& limits() const noexcept { return limits_; }
    /// Replaces the look-ahead of three braking distances, in m; before the first point. For tests and benches.
    void set_window(double length) noexcept { limits_.window = length; }
    [[nodiscard]] const WindowCounts& counts() const noexcept { return window_.counts(); }

private:
    enum class Stage : std::uint8_t { seek, curve, complete };

    [[nodiscard]] std::expected<void, Refusal> ready_for_point() const noexcept;
    [[nodiscard]] std::expected<Place, Refusal> usable(const Place& point) noexcept;
    void add_arc_points() noexcept;
    [[nodiscard]] std::uint32_t seek() noexcept;
    [[nodiscard]] std::uint32_t follow_curve() noexcept;
    /// What comes behind a corner.
    struct Behind {
        Stub stub;  ///< of the points
        Stub line;  ///< as it is run: with the corners at both ends moved
        Place corner{};
        Joint joint;
    };
    [[nodiscard]] bool look_behind(std::uint32_t corner, const Stub& before, const Place& from,
                                   Behind& behind) const noexcept;
    [[nodiscard]] bool is_end(std::uint32_t point) const noexcept {
        return points_.closed() && point + 1 == points_.end();
    }
    void write_line(const Stub& line, const Joint& end) noexcept;
    /// The ramp between a corner and a curve.
    struct End {
        double jerk = 0.0;
        double length = 0.0;
    };
    [[nodiscard]] End ramp_at(const Stub& stub, const Joint& joint) const noexcept;
    void next_run(std::uint32_t corner, const Behind& behind) noexcept;

    Polyline points_;
    Ring<Node> nodes_;
    TrajectoryWriter writer_;
    SplineBuilder spline_;
    WindowPlanner window_;
    Limits limits_;
    Stage stage_ = Stage::complete;
    bool open_ = false;
    bool finished_ = false;
    std::uint32_t count_ = 0;
    Place still_{};  ///< axes that must not move
    Place last_{};   ///< point, scaled
    Arc arc_;        ///< what is left of it to be added
    std::uint32_t last_item_ = 0;
    std::uint32_t arc_item_ = 0;

    std::uint32_t corner_ = 0;  ///< where the run begins
    Behind run_;                ///< of that corner
    bool has_run_ = false;
    Behind next_;  ///< of the corner at which a curve ends
};

}  // namespace sc::trajectory
