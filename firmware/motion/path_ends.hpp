// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "firmware/trajectory/spec.hpp"

namespace sc::motion {

/// Moves the first point of a path back by the run-in and its last one on by the run-out, each straight along the
/// path's end and as long as it takes to reach full speed, so that the marked part is passed moving.
///
/// Points nearer than `merge` to the last one given on are kept back: they say nothing about the direction. A path that
/// begins or ends with an arc gets a straight run-in or run-out along the arc's tangent. Cost: bounded, some 60
/// operations a point and two roots; some 1 000 an arc.
class PathEnds {
public:
    /// A point to be planned, or an arc that ends there.
    struct Point {
        trajectory::Place place{};
        std::uint32_t item = 0;
        bool arc = false;
        trajectory::Place via{};
    };
    /// What is to be planned, in this order.
    struct Points {
        std::array<Point, 3> each{};
        std::uint32_t size = 0;
        void push(const Point& point) noexcept {
            each[size] = point;
            ++size;
        }
    };

    /// `speed` in m/s, that the run-in is to reach; `merge` in m.
    void open(double speed, double merge, const trajectory::AxisLimits& limits) noexcept;
    /// Next point, or an arc to it; appends what is to be planned now. An arc can not be the first.
    void add(const Point& point, Points& given) noexcept;
    /// No more points; the last to be planned. Nothing if there were no two distinct points.
    void finish(Points& given) noexcept;

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
    void begin(const trajectory::Place& direction) noexcept;

    double speed_ = 0.0;
    double merge_ = 0.0;
    trajectory::AxisLimits limits_;
    bool has_point_ = false;
    bool started_ = false;
    bool finished_ = false;
    double run_in_ = 0.0;
    double run_out_ = 0.0;
    trajectory::Place start_{};
    trajectory::Place before_{};  ///< that the last one kept was come from, straight
    Point held_;                  ///< the last one kept
    bool given_ = false;          ///< … was given on, as the end of an arc that arrives in direction `arrives_`
    trajectory::Place arrives_{};
    Point last_;  ///< the last that came
};

}  // namespace sc::motion
