// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/motion/element_ring.hpp"

namespace sc::motion {

/// How a path is to be run; base units.
struct PathSpec {
    double speed = 0.0;
    double tolerance = 0.0;  ///< m
    AxisLimits limits;
};

/// Turns points into elements one by one: lines, and a blend at each corner that the tolerance allows to round. The
/// first line is extended backward by the run-in and the last forward by the run-out, each the distance to full speed,
/// so that the marked part is passed moving. A corner sharper than 120°, or any corner of a path without tolerance, is
/// a stop.
///
/// Cost: bounded, some 600 operations a point. Appends at most two elements a point: keep two free.
class PathBuilder {
public:
    void open(const PathSpec& spec) noexcept;
    /// Next point of the path and the number of its item. Points nearer than 1 nm to their predecessor are passed over.
    void add(const Place& point, std::uint32_t item, ElementRing& ring) noexcept;
    /// Path end. False if there were no two distinct points.
    [[nodiscard]] bool finish(ElementRing& ring) noexcept;

    /// Two distinct points are known, so start() is.
    [[nodiscard]] bool has_start() const noexcept { return has_direction_; }
    /// Where the run-in begins.
    [[nodiscard]] const Place& start() const noexcept { return start_; }
    [[nodiscard]] bool finished() const noexcept { return finished_; }
    /// True distance from the start of the run-in at which marking begins, and (once finished) ends.
    [[nodiscard]] double mark_begin() const noexcept { return run_in_; }
    [[nodiscard]] double mark_end() const noexcept { return mark_end_; }

private:
    void emit_line(double length, bool stop, ElementRing& ring) noexcept;
    void corner(const Place& direction, double length, ElementRing& ring) noexcept;

    PathSpec spec_;
    bool has_point_ = false;
    bool has_direction_ = false;
    bool finished_ = false;
    Place start_{};
    Place vertex_{};            ///< last point
    Place direction_{};         ///< of the segment that ends there
    Place line_from_{};         ///< where the not yet emitted line begins
    double line_length_ = 0.0;  ///< from there to the vertex
    double segment_length_ = 0.0;
    double run_in_ = 0.0;
    double mark_end_ = 0.0;
    std::uint32_t item_ = 0;  ///< of the point where the pending line begins
    std::uint32_t vertex_item_ = 0;
};

}  // namespace sc::motion
