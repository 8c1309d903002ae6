// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "firmware/motion/axis_map.hpp"
#include "firmware/motion/backlash.hpp"
#include "firmware/trajectory/spec.hpp"
#include "shared/machine/axis_map.hpp"

namespace sc::motion {

/// Places to set-points and back through all that calibration knows: the matrix, and the axis map if one is in force.
/// Without a map it is the matrix alone, in the same bits and for three instructions more. Servo context: no division
/// and no root; with a map some 700 instructions a tick. About 5 kB.
class AxisGeometry {
public:
    explicit AxisGeometry(const MachineConfig& machine) noexcept;

    /// Only while nothing moves: the set-points of a place change at once.
    void set(const Compensation& compensation) noexcept { compensation_ = compensation; }
    /// A map that check_map has passed with this cost.
    void set(const AxisMap& map, const MapCost& cost) noexcept;

    /// Set-points of a tick. Once a tick: it also follows the way that the axes move, for their backlash.
    [[nodiscard]] AxisPositions set_point_of(const Place& place) noexcept;
    /// Others move this axis, and its set-point follows it: no crossing of its backlash can be under way.
    void settle(std::size_t axis) noexcept { backlash_[axis].settle(); }
    /// The place whose set-points are `axes`, with the backlash as it stands. Eight rounds; the map gains two digits
    /// in each.
    [[nodiscard]] Place place_of(const AxisPositions& axes) const noexcept;

    /// How far the set-point of Y can lie below a place y, wherever X and Z stand within their travel; 0 or more.
    [[nodiscard]] double y_shortfall(double y) const noexcept;
    /// Largest correction of X, Y or Z by the map alone, metres.
    [[nodiscard]] double map_shift(std::size_t axis) const noexcept { return map_shift_[axis]; }

    [[nodiscard]] bool mapped() const noexcept { return mapped_; }
    [[nodiscard]] const Compensation& compensation() const noexcept { return compensation_; }

private:
    static constexpr std::size_t kTurnWrapped = kTurnNodes + 3;
    struct Cell;
    [[nodiscard]] static Cell cell_of(double place, double first, double per_spacing, double last) noexcept;
    [[nodiscard]] Place axes_of(const Place& place) const noexcept;

    MachineConfig machine_;
    Compensation compensation_;
    bool mapped_ = false;
    std::array<double, 3> first_{};
    std::array<double, 3> per_spacing_{};  ///< 0: no table along this axis
    std::array<std::array<std::array<double, kMapCoefficients>, 3>, 3>
        linear_{};                                                      ///< [along][correction of], metres / 6
    std::array<std::array<double, kTurnWrapped>, kTurnTables> turn_{};  ///< metres, degrees or radians / 6
    std::array<double, kAxisCount> map_shift_{};
    bool turned_ = false;  ///< a table over C is there
    Vec3 pivot_;
    std::array<Backlash, kAxisCount> backlash_;
};

}  // namespace sc::motion
