// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "shared/codes/codes.hpp"
#include "shared/geometry/vec.hpp"
#include "shared/machine/machine.hpp"

/// What calibration found of the axes beyond the matrix of `Compensation`: straightness and pitch of X, Y, Z, the
/// turntable's pitch, shift and tilt over C, and backlash. All of it is a correction of what is commanded:
///
///     p' = p + shift(c) + tilt(c) × (p − pivot)      the workpiece has moved with an imperfect table
///     n  = matrix · p' + offset                      (Compensation)
///     q  = n + t_x(n_x) + t_y(n_y) + t_z(n_z)        three tables for each of X, Y, Z
///     q_c = c + angle(c)
///
/// and to each axis ± half its backlash, by the way it last moved. Tables are uniform cubic B-splines: smooth to the
/// second derivative, and within the hull of their coefficients, which is what the bounds below rest on.

namespace sc {

inline constexpr std::size_t kMapNodes = 33;                    ///< of a linear axis, from `first` on
inline constexpr std::size_t kMapCoefficients = kMapNodes + 2;  ///< coefficient k belongs to node k − 1
inline constexpr std::size_t kTurnNodes = 36;                   ///< of C: every 10°, periodic; coefficient k to node k
inline constexpr double kTurnSpacing = 360.0 / static_cast<double>(kTurnNodes);

/// Tables over C. Tilts are rotations about the axes of h.
enum class TurnTable : std::uint8_t { angle = 0, shift_x = 1, shift_y = 2, shift_z = 3, tilt_x = 4, tilt_y = 5 };
inline constexpr std::size_t kTurnTables = 6;

/// Integers on the controller's grid: picometres, nanodegrees, and 1e-12 rad for tilts.
struct AxisMap {
    using LinearTable = std::array<std::int32_t, kMapCoefficients>;
    using TurnCoefficients = std::array<std::int32_t, kTurnNodes>;

    std::array<double, 3> first{};                       ///< metres: node 0 of the tables along X, Y, Z
    std::array<double, 3> spacing{};                     ///< metres, between nodes; 0: no table along this axis
    std::array<std::array<LinearTable, 3>, 3> linear{};  ///< [correction of][along]
    std::array<TurnCoefficients, kTurnTables> turn{};    ///< by TurnTable
    Vec3 pivot;                                          ///< metres, h: the place that a tilt leaves where it is
    std::array<std::int32_t, kAxisCount> backlash{};     ///< whole width, 0 or more
    std::array<double, kAxisCount> take_up{};            ///< seconds that the way through the backlash takes

    constexpr bool operator==(const AxisMap&) const noexcept = default;
    [[nodiscard]] bool is_identity() const noexcept;
};
/// The identity.
inline constexpr AxisMap kNoMap{};
inline bool AxisMap::is_identity() const noexcept { return *this == kNoMap; }

/// Largest correction of a linear axis (metres) and of C (degrees): a compensation is small.
inline constexpr double kMapLargestShift = 300e-6;
inline constexpr double kMapLargestAngle = 0.1;
/// What a map may add to an axis, of its limits, with every axis at full speed, acceleration and jerk.
inline constexpr double kMapSpeedShare = 0.02;
inline constexpr double kMapTableSpeedShare = 0.01;  ///< of that, tables alone: a spike of a measurement is steeper
inline constexpr double kMapAccelerationShare = 0.05;
inline constexpr double kMapJerkShare = 0.15;

/// What a map adds at most, in base units of each axis and over s, s² and s³.
struct MapCost {
    std::array<double, kAxisCount> shift{};
    std::array<double, kAxisCount> speed{};
    std::array<double, kAxisCount> acceleration{};
    std::array<double, kAxisCount> jerk{};
};

/// What is wrong with a map; `refusal` is none for a good one.
struct MapFinding {
    static constexpr std::uint8_t kBacklash = 4;  ///< `along`: not a table
    Refusal refusal = Refusal::none;
    std::uint8_t axis = 0;   ///< whose set-point is corrected
    std::uint8_t along = 0;  ///< axis whose place the table is over
    std::uint8_t node = 0;   ///< nearest to the worst place
    /// All three in one number, as CommandReply::detail carries it.
    [[nodiscard]] constexpr std::int64_t detail() const noexcept {
        return (std::int64_t{axis} * 10 + along) * 100 + node;
    }
    [[nodiscard]] static constexpr MapFinding from_detail(Refusal refusal, std::int64_t detail) noexcept {
        return {refusal, static_cast<std::uint8_t>(detail / 1000 % 10), static_cast<std::uint8_t>(detail / 100 % 10),
                static_cast<std::uint8_t>(detail % 100)};
    }
};

/// `bad_map`: a number that is none, a table that does not reach over its axis' travel, a correction or a backlash out
/// of range. `map_too_steep`: it adds more than its share of a limit (the node whose table adds most). Fills in `cost`,
/// which bounds every motion that keeps the machine's limits in h. Some 20 000 operations, no heap; not for a tick that
/// moves.
[[nodiscard]] MapFinding check_map(const MachineConfig& machine, const AxisMap& map, MapCost& cost) noexcept;

}  // namespace sc
