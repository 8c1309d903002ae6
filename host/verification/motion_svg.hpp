// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "host/verification/motion_checker.hpp"
#include "host/verification/motion_trace.hpp"

namespace sc::host {

/// A self-contained picture: speed, acceleration and jerk of X, Y, Z and of the path, those of C if it moves, and the
/// deviation if a path was given, each over time with its limits; broken places are marked. Every column of pixels
/// shows the least and the greatest of its samples, so that no peak is lost and 100 000 ticks stay below 1 MB. Where
/// the drives lead (`led` = 0) nothing is drawn. Linear in the samples. Pure.
[[nodiscard]] std::string motion_svg(std::string_view title, const MotionTrace& trace, const MotionLimits& limits,
                                     const MotionReport& report);

}  // namespace sc::host
