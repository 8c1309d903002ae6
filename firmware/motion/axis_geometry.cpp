// SPDX-License-Identifier: Apache-2.0
#include "firmware/motion/axis_geometry.hpp"

namespace sc::motion {
namespace {

constexpr std::size_t kC = index(Axis::c);
/// Reversals by less than half a drive count do not reach the drive.
constexpr double kDeadCounts = 0.5;
constexpr double kPerTurnSpacing = 1.0 / kTurnSpacing;
/// C stays within two turns either way of 0.
constexpr double kTurnFirst = -720.0;
constexpr double kTurnLast = 4.0 * static_cast<double>(kTurnNodes) - 1e-6;

constexpr double grid_of(std::size_t axis) noexcept { return axis == kC ? 1e-9 : 1e-12; }
constexpr double turn_grid(std::size_t table) noexcept { return table == 0 ? 1e-9 : 1e-12; }

}  // namespace

/// The four coefficients about a place and six times their weights.
struct AxisGeometry::Cell {
    std::size_t first = 0;
    std::array<double, 4> weight{};

    template <std::size_t N>
    [[nodiscard]] double of(const std::array<double, N>& table) const noexcept {
        const double* c = table.data() + first;
        return (weight[0] * c[0] + weight[1] * c[1]) + (weight[2] * c[2] + weight[3] * c[3]);
    }
};

AxisGeometry::Cell AxisGeometry::cell_of(double place, double first, double per_spacing, double last) noexcept {
    const double u = clamped((place - first) * per_spacing, 0.0, last);
    Cell cell;
    const auto whole = static_cast<std::uint32_t>(u);
    cell.first = whole;
    const double f = u - static_cast<double>(whole);
    const double g = 1.0 - f;
    const double ff = f * f;
    const double gg = g * g;
    cell.weight[0] = gg * g;
    cell.weight[1] = 4.0 - 3.0 * ff * (2.0 - f);
    cell.weight[2] = 4.0 - 3.0 * gg * (2.0 - g);
    cell.weight[3] = ff * f;
    return cell;
}

AxisGeometry::AxisGeometry(const MachineConfig& machine) noexcept : machine_(machine) {}

double AxisGeometry::y_shortfall(double y) const noexcept {
    const Vec3& row = compensation_.axis_from_h.row[1];
    double lowest = ((row.y - 1.0) * y + compensation_.axis_offset.y) - map_shift_[index(Axis::y)];
    for (const std::size_t i : {std::size_t{0}, std::size_t{2}}) {
        lowest = lowest + smaller(row[i] * machine_.axis[i].travel_min, row[i] * machine_.axis[i].travel_max);
    }
    return larger(-lowest, 0.0);
}

void AxisGeometry::set(const AxisMap& map, const MapCost& cost) noexcept {
    mapped_ = !map.is_identity();
    map_shift_ = cost.shift;
    first_ = map.first;
    pivot_ = map.pivot;
    constexpr double kSixth = 1.0 / 6.0;
    for (std::size_t j = 0; j < 3; ++j) {
        per_spacing_[j] = map.spacing[j] > 0.0 ? 1.0 / map.spacing[j] : 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < kMapCoefficients; ++k) {
                linear_[j][i][k] = static_cast<double>(map.linear[i][j][k]) * (1e-12 * kSixth);
            }
        }
    }
    turned_ = map.turn != kNoMap.turn;
    for (std::size_t table = 0; table < kTurnTables; ++table) {
        for (std::size_t k = 0; k < kTurnWrapped; ++k) {
            // A cell takes the node before it too.
            const std::size_t node = (k + kTurnNodes - 1) % kTurnNodes;
            turn_[table][k] = static_cast<double>(map.turn[table][node]) * (turn_grid(table) * kSixth);
        }
    }
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const double ticks = map.take_up[i] * 1e9 / static_cast<double>(machine_.control_period_ns);
        const double width = static_cast<double>(map.backlash[i]) * grid_of(i);
        const AxisConfig& axis = machine_.axis[i];
        const double jump = 2e-9 * axis.speed * static_cast<double>(machine_.control_period_ns);
        backlash_[i] =
            map.backlash[i] > 0 ? Backlash(width, kDeadCounts / axis.counts_per_unit, ticks, jump) : Backlash();
    }
}

/// Readings that the axes must have, without their backlash.
Place AxisGeometry::axes_of(const Place& place) const noexcept {
    Vec3 p{place[0], place[1], place[2]};
    double c = place[kC];
    if (turned_) {
        Cell cell = cell_of(c, kTurnFirst, kPerTurnSpacing, kTurnLast);
        while (cell.first >= kTurnNodes) {
            cell.first -= kTurnNodes;
        }
        const auto value = [&](TurnTable table) noexcept { return cell.of(turn_[static_cast<std::size_t>(table)]); };
        const Vec3 r = p - pivot_;
        const double tilt_x = value(TurnTable::tilt_x);
        const double tilt_y = value(TurnTable::tilt_y);
        p.x = p.x + (value(TurnTable::shift_x) + tilt_y * r.z);
        p.y = p.y + (value(TurnTable::shift_y) - tilt_x * r.z);
        p.z = p.z + (value(TurnTable::shift_z) + (tilt_x * r.y - tilt_y * r.x));
        c = c + value(TurnTable::angle);
    }
    const Vec3 nominal = axes_from_h(compensation_, p);
    std::array<double, 3> q{nominal.x, nominal.y, nominal.z};
    for (std::size_t j = 0; j < 3; ++j) {
        if (per_spacing_[j] > 0.0) {
            constexpr double kLast = static_cast<double>(kMapNodes - 1) - 1e-6;
            const Cell cell = cell_of(nominal[j], first_[j], per_spacing_[j], kLast);
            for (std::size_t i = 0; i < 3; ++i) {
                q[i] = q[i] + cell.of(linear_[j][i]);
            }
        }
    }
    return {q[0], q[1], q[2], c};
}

AxisPositions AxisGeometry::set_point_of(const Place& place) noexcept {
    if (!mapped_) {
        return motion::set_point_of(compensation_, place);
    }
    const Place axes = axes_of(place);
    AxisPositions out{};
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        backlash_[i].step(axes[i]);
        out[i] = nearest((axes[i] + backlash_[i].offset()) * (i == kC ? kNdegPerDegree : kPmPerMetre));
    }
    return out;
}

Place AxisGeometry::place_of(const AxisPositions& axes) const noexcept {
    if (!mapped_) {
        return motion::place_of(compensation_, axes);
    }
    Place wanted{};
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        wanted[i] = exact_double(axes[i]) / (i == kC ? kNdegPerDegree : kPmPerMetre) - backlash_[i].offset();
    }
    Place place = wanted;
    for (int round = 0; round < 8; ++round) {
        const Place reached = axes_of(place);
        for (std::size_t i = 0; i < kAxisCount; ++i) {
            place[i] = place[i] + (wanted[i] - reached[i]);
        }
    }
    return place;
}

}  // namespace sc::motion
