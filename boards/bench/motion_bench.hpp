// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <expected>
#include <vector>

#include "firmware/trajectory/planner.hpp"

namespace sc::bench {

/// What a plan of a polyline comes to. Shares and deviation are taken from 1 kHz samples of the place alone.
struct MotionFigures {
    double seconds = 0.0;          ///< of motion, rest to rest
    double limit_ratio = 0.0;      ///< worst sample of path speed and of each axis' speed, acceleration and jerk
    double deviation = 0.0;        ///< m, worst sample, passed in order
    double us_per_point = 0.0;     ///< of computing, best of the repeats
    double worst_insert_us = 0.0;  ///< one point and the work behind it, in that repeat
    std::size_t points = 0;
    std::size_t pieces = 0;
    std::vector<trajectory::Place> samples;  ///< at 1 kHz, some at rest before and behind
};

/// Plans the polyline `repeats` times and measures. The refusal names the point.
[[nodiscard]] std::expected<MotionFigures, trajectory::Refusal> measure(const trajectory::Spec& spec,
                                                                        const std::vector<trajectory::Place>& points,
                                                                        int repeats);

/// Time of motion with a look-ahead of 256 points (of mean spacing) over that with an unlimited one.
[[nodiscard]] std::expected<double, trajectory::Refusal> horizon_ratio(const trajectory::Spec& spec,
                                                                       const std::vector<trajectory::Place>& points);

}  // namespace sc::bench
