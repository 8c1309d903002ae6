// SPDX-License-Identifier: Apache-2.0
#include "shared/machine/axis_map.hpp"

#include <span>

namespace sc {
namespace {

constexpr double kGrid = 1e-12;     ///< metres or radians a unit
constexpr double kTurnGrid = 1e-9;  ///< degrees a unit
constexpr double kSlowestTakeUp = 0.5;

constexpr double magnitude(double v) noexcept { return v < 0.0 ? -v : v; }
constexpr bool finite(double v) noexcept { return v >= -1e300 && v <= 1e300; }

/// Bounds of a quantity and of its first three derivatives.
struct Bounds {
    std::array<double, 4> d{};
    std::array<std::uint8_t, 4> node{};  ///< where each is largest
};

/// Of the motion of an axis: its place within `reach` of a reference.
Bounds motion_of(const AxisConfig& axis, double reach) noexcept {
    return {{reach, axis.speed, axis.acceleration, axis.jerk}, {}};
}

/// Of a cubic B-spline over its argument. Each derivative is a spline of differences, within the hull of these.
Bounds table_bounds(std::span<const std::int32_t> coefficients, double spacing, double grid, bool periodic) noexcept {
    Bounds bounds;
    const std::size_t n = coefficients.size();
    if (n < bounds.d.size()) {
        return bounds;  // refused before, by its form
    }
    const auto at = [&](std::size_t k) noexcept { return static_cast<double>(coefficients[k < n ? k : k - n]); };
    double scale = grid;
    for (std::size_t order = 0; order < 4; ++order) {
        const std::size_t count = periodic ? n : n - order;
        for (std::size_t k = 0; k < count; ++k) {
            double value = at(k);
            if (order == 1) {
                value = at(k + 1) - at(k);
            } else if (order == 2) {
                value = at(k + 2) - 2.0 * at(k + 1) + at(k);
            } else if (order == 3) {
                value = (at(k + 3) - at(k)) - 3.0 * (at(k + 2) - at(k + 1));
            }
            if (magnitude(value) * scale > bounds.d[order]) {
                bounds.d[order] = magnitude(value) * scale;
                bounds.node[order] = static_cast<std::uint8_t>(k);
            }
        }
        scale /= spacing;
    }
    return bounds;
}

/// Chain rule: table(place(t)).
Bounds along(const Bounds& table, const Bounds& motion) noexcept {
    const auto& t = table.d;
    const auto& m = motion.d;
    return {{t[0], t[1] * m[1], t[2] * m[1] * m[1] + t[1] * m[2],
             t[3] * m[1] * m[1] * m[1] + 3.0 * t[2] * m[1] * m[2] + t[1] * m[3]},
            {table.node[0], table.node[1], table.node[2], table.node[3]}};
}

/// Leibniz' rule: tilt(t) · lever(t).
Bounds product(const Bounds& a, const Bounds& b) noexcept {
    const auto& f = a.d;
    const auto& g = b.d;
    return {{f[0] * g[0], f[1] * g[0] + f[0] * g[1], f[2] * g[0] + 2.0 * f[1] * g[1] + f[0] * g[2],
             f[3] * g[0] + 3.0 * f[2] * g[1] + 3.0 * f[1] * g[2] + f[0] * g[3]},
            a.node};
}

/// Sums what is added to one axis, and remembers which table adds most of each.
class Sum {
public:
    explicit Sum(std::size_t axis) noexcept : axis_(axis) {}
    void add(const Bounds& bounds, std::size_t along_axis) noexcept {
        for (std::size_t order = 0; order < 4; ++order) {
            total_[order] += bounds.d[order];
            if (bounds.d[order] > largest_[order]) {
                largest_[order] = bounds.d[order];
                along_[order] = static_cast<std::uint8_t>(along_axis);
                node_[order] = bounds.node[order];
            }
        }
    }
    [[nodiscard]] double operator[](std::size_t order) const noexcept { return total_[order]; }
    [[nodiscard]] MapFinding blame(Refusal refusal, std::size_t order) const noexcept {
        return {refusal, static_cast<std::uint8_t>(axis_), along_[order], node_[order]};
    }

private:
    std::size_t axis_;
    std::array<double, 4> total_{};
    std::array<double, 4> largest_{};
    std::array<std::uint8_t, 4> along_{};
    std::array<std::uint8_t, 4> node_{};
};

double reach_of(const AxisConfig& axis, double from) noexcept {
    const double low = magnitude(axis.travel_min - from);
    const double high = magnitude(axis.travel_max - from);
    return low < high ? high : low;
}

MapFinding bad(std::size_t axis, std::size_t along_axis) noexcept {
    return {Refusal::bad_map, static_cast<std::uint8_t>(axis), static_cast<std::uint8_t>(along_axis), 0};
}

/// Numbers that are none, and tables that end within the travel.
MapFinding check_form(const MachineConfig& machine, const AxisMap& map) noexcept {
    for (std::size_t i = 0; i < 3; ++i) {
        if (!finite(map.first[i]) || !finite(map.spacing[i]) || map.spacing[i] < 0.0 || !finite(map.pivot[i])) {
            return bad(i, i);
        }
        bool used = false;
        for (std::size_t of = 0; of < 3; ++of) {
            used = used || map.linear[of][i] != AxisMap::LinearTable{};
        }
        const double last = map.first[i] + map.spacing[i] * static_cast<double>(kMapNodes - 1);
        const AxisConfig& axis = machine.axis[i];
        if (used && !(map.spacing[i] > 0.0 && map.first[i] <= axis.travel_min && last >= axis.travel_max)) {
            return bad(i, i);
        }
    }
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const double two_ticks = 2e-9 * static_cast<double>(machine.control_period_ns);
        const bool none = map.backlash[i] == 0;
        if (map.backlash[i] < 0 || !finite(map.take_up[i]) ||
            (!none && !(map.take_up[i] >= two_ticks && map.take_up[i] <= kSlowestTakeUp))) {
            return bad(i, MapFinding::kBacklash);
        }
    }
    return {};
}

/// Two pieces of jerk 32·width / T³ and one of its opposite between them (firmware/motion/backlash.hpp).
Bounds take_up_bounds(double width, double time) noexcept {
    if (!(width > 0.0)) {
        return {};
    }
    return {{0.5 * width, 2.0 * width / time, 8.0 * width / (time * time), 32.0 * width / (time * time * time)}, {}};
}

/// What an axis is asked for in all, against its limits.
MapFinding judge(const Sum& sum, const AxisConfig& axis, bool turns) noexcept {
    if (!(sum[0] <= (turns ? kMapLargestAngle : kMapLargestShift))) {
        return sum.blame(Refusal::bad_map, 0);
    }
    if (!(sum[1] <= kMapSpeedShare * axis.speed)) {
        return sum.blame(Refusal::map_too_steep, 1);
    }
    if (!(sum[2] <= kMapAccelerationShare * axis.acceleration)) {
        return sum.blame(Refusal::map_too_steep, 2);
    }
    if (!(sum[3] <= kMapJerkShare * axis.jerk)) {
        return sum.blame(Refusal::map_too_steep, 3);
    }
    return {};
}

}  // namespace

MapFinding check_map(const MachineConfig& machine, const AxisMap& map, MapCost& cost) noexcept {
    cost = {};
    if (const MapFinding finding = check_form(machine, map); finding.refusal != Refusal::none) {
        return finding;
    }
    constexpr std::size_t kC = index(Axis::c);
    const Bounds turning = motion_of(machine.axis[kC], 0.0);
    std::array<Bounds, kTurnTables> turn;
    for (std::size_t k = 0; k < kTurnTables; ++k) {
        turn[k] = along(table_bounds(map.turn[k], kTurnSpacing, k == 0 ? kTurnGrid : kGrid, true), turning);
    }
    const auto of_turn = [&](TurnTable table) noexcept -> const Bounds& {
        return turn[static_cast<std::size_t>(table)];
    };
    const auto lever = [&](std::size_t axis) noexcept {
        return motion_of(machine.axis[axis], reach_of(machine.axis[axis], map.pivot[axis]));
    };
    constexpr std::array<TurnTable, 3> kShifts{TurnTable::shift_x, TurnTable::shift_y, TurnTable::shift_z};
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        Sum sum(i);
        if (i == kC) {
            sum.add(of_turn(TurnTable::angle), kC);
        } else {
            for (std::size_t j = 0; j < 3; ++j) {
                if (map.spacing[j] > 0.0) {
                    sum.add(along(table_bounds(map.linear[i][j], map.spacing[j], kGrid, false),
                                  motion_of(machine.axis[j], 0.0)),
                            j);
                }
            }
            sum.add(of_turn(kShifts[i]), kC);
            if (i != index(Axis::x)) {
                sum.add(product(of_turn(TurnTable::tilt_x), lever(i == index(Axis::y) ? 2 : 1)), kC);
            }
            if (i != index(Axis::y)) {
                sum.add(product(of_turn(TurnTable::tilt_y), lever(i == index(Axis::x) ? 2 : 0)), kC);
            }
        }
        if (!(sum[1] <= kMapTableSpeedShare * machine.axis[i].speed)) {
            return sum.blame(Refusal::map_too_steep, 1);
        }
        sum.add(take_up_bounds(static_cast<double>(map.backlash[i]) * (i == kC ? kTurnGrid : kGrid), map.take_up[i]),
                MapFinding::kBacklash);
        cost.shift[i] = sum[0];
        cost.speed[i] = sum[1];
        cost.acceleration[i] = sum[2];
        cost.jerk[i] = sum[3];
        if (const MapFinding finding = judge(sum, machine.axis[i], i == kC); finding.refusal != Refusal::none) {
            return finding;
        }
    }
    return {};
}

}  // namespace sc
