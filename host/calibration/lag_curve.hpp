// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "host/formats/lag_plate.hpp"

/// Geometry of the lines that show how the mirrors follow (host/formats/lag_plate.hpp).

namespace sc::host {

/// A line as it is drawn, over the distance along it. Beyond its ends it goes straight on.
class LagCurve {
public:
    explicit LagCurve(const LagLine& line);

    struct Point {
        std::array<double, 2> place{};
        std::array<double, 2> tangent{};    ///< unit
        std::array<double, 2> curvature{};  ///< second derivative by distance, 1/m
    };
    [[nodiscard]] double length() const { return distance_.back(); }
    [[nodiscard]] Point at(double distance) const;
    /// Place at `u`, metres along the line's axis from its start.
    [[nodiscard]] std::array<double, 2> place_of(double u) const;

private:
    [[nodiscard]] double slope_at(double u) const;
    [[nodiscard]] double axis_of(double distance) const;

    LagLine line_;
    double wave_ = 0.0;  ///< rad / m
    double step_ = 0.0;
    std::vector<double> distance_;  ///< at each step along the axis
};

}  // namespace sc::host
