// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "firmware/trajectory/spec.hpp"

namespace sc::motion {

/// Moves the first point of a path back by the run-in and its last one on by the run-out, each straight along the
/// path's end and as long as it takes to reach full speed, so that the marked part is passed moving.
///
/// Points nearer than `merge` to the last one given on are kept back: they say nothing about the direction. Cost:
/// bounded, some 60 operations a point and two roots.
class PathEnds {
public:
    /// A point to be planned.
    struct Point {
        trajectory::Place place{};
        std::uint32_t item = 0;
    };

    /// `speed` in m/s, that the run-in is to reach; `merge` in m.
    void open(double speed, double merge, const trajectory::AxisLimits& limits) noexcept;
    /// Next point; what is to be planned before it, if anything.
    [[nodiscard]] std::optional<Point> add(const trajectory::Place& point, std::uint32_t item) noexcept;
    /// No more points; the last to be planned. Nothing if there were no two distinct points.
    [[nodiscard]] std::optional<Point> finish() noexcept;

    /// Two distinct points are known.
    [[nodiscard]] bool has_start() const noexcept { return started_; }
    /// Where the run-in begins.
    [[nodiscard]] const trajectory::Place& start() const noexcept { return start_; }
    [[nodiscard]] bool finished() const noexcept { return finished_; }
    /// Where the run-out ends.
    [[nodiscard]] const trajectory::Place& last() const noexcept { return last_.place; }
    /// Their lengths, m. Before finished() the run-out is the longest that it can be.
    [[nodiscard]] double run_in() const noexcept { return run_in_; }
    [[nodiscard]] double run_out() const noexcept { return run_out_; }

private:
    [[nodiscard]] double run_up(const trajectory::Place& direction) const noexcept;

    double speed_ = 0.0;
    double merge_ = 0.0;
    trajectory::AxisLimits limits_;
    bool has_point_ = false;
    bool started_ = false;
    bool finished_ = false;
    double run_in_ = 0.0;
    double run_out_ = 0.0;
    trajectory::Place start_{};
    Point before_;  ///< the last one that was given on, in its true place
    Point held_;    ///< the next to be given on
    Point last_;    ///< the last that came
};

}  // namespace sc::motion
