// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>

#include "host/calibration/axis_map_fit.hpp"
#include "host/calibration/map_solver.hpp"
#include "host/calibration/transforms.hpp"
#include "host/formats/text.hpp"

namespace sc::host {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kDegree = M_PI / 180.0;
constexpr std::size_t kFewestTargets = 3;
constexpr std::size_t kFewestPoints = 60;
constexpr std::size_t kTables = kTurnTables * kTurnNodes;
/// Beliefs before any measurement, for shifts (m) and for angles (rad).
constexpr double kShiftSigma = 200e-6;
constexpr double kShiftBend = 10e-6;
constexpr double kAngleSigma = 1e-3;
constexpr double kAngleBend = 30e-6;
constexpr double kPlaceSigma = 1e-3;
constexpr double kAtZero = 1e-9;
constexpr double kReach = 0.2;  ///< metres from the pivot at which the corrections must be certain

constexpr bool is_shift(std::size_t table) { return table >= 1 && table <= 3; }

/// Where everything stands among the unknowns: tables, half the backlash, then the targets' places.
struct Layout {
    bool backlash = false;
    std::map<int, std::size_t> target;  ///< number in the file to place in the list
    [[nodiscard]] std::size_t places() const { return kTables + (backlash ? 1 : 0); }
    [[nodiscard]] std::size_t unknowns() const { return places() + 3 * target.size(); }
};

/// Adds table(c) · factor to a row.
void add_table(VectorXd& row, std::size_t table, double c_deg, double factor) {
    const double turn = c_deg - 360.0 * std::floor(c_deg / 360.0);
    const SplineCell cell = spline_cell(turn, 0.0, kTurnSpacing, kTurnNodes);
    for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t node = (cell.first + k + kTurnNodes - 1) % kTurnNodes;
        row[static_cast<Index>(table * kTurnNodes + node)] += factor * cell.weight[k];
    }
}

/// The three rows of what moves a place r at C: shift + tilt × (r − pivot) − (angle + approach · half) · (u × (r − a)).
std::array<VectorXd, 3> motion_rows(const Layout& layout, const AxisLine& axis, const Vec3& pivot, const Vec3& r,
                                    double c_deg, int approach) {
    const Vec3 turned = cross(axis.direction.v, r - axis.point.v);
    const Vec3 by_x = cross(Vec3{1.0, 0.0, 0.0}, r - pivot);
    const Vec3 by_y = cross(Vec3{0.0, 1.0, 0.0}, r - pivot);
    std::array<VectorXd, 3> rows;
    for (std::size_t i = 0; i < 3; ++i) {
        rows[i] = VectorXd::Zero(static_cast<Index>(layout.unknowns()));
        add_table(rows[i], static_cast<std::size_t>(TurnTable::angle), c_deg, -turned[i]);
        add_table(rows[i], static_cast<std::size_t>(TurnTable::shift_x) + i, c_deg, 1.0);
        add_table(rows[i], static_cast<std::size_t>(TurnTable::tilt_x), c_deg, by_x[i]);
        add_table(rows[i], static_cast<std::size_t>(TurnTable::tilt_y), c_deg, by_y[i]);
        if (layout.backlash) {
            rows[i][static_cast<Index>(kTables)] = -turned[i] * approach;
        }
    }
    return rows;
}

void believe(MapSolver& solver, const Layout& layout) {
    const auto size = static_cast<Index>(layout.unknowns());
    for (std::size_t k = 0; k < layout.unknowns(); ++k) {
        const bool shift = k < kTables && is_shift(k / kTurnNodes);
        const double sigma = k >= layout.places() ? kPlaceSigma : (shift ? kShiftSigma : kAngleSigma);
        solver.believe(VectorXd::Unit(size, static_cast<Index>(k)), 0.0, sigma);
    }
    for (std::size_t table = 0; table < kTurnTables; ++table) {
        for (std::size_t k = 0; k < kTurnNodes; ++k) {
            VectorXd row = VectorXd::Zero(size);
            const auto at = [&](std::size_t step) {
                return static_cast<Index>(table * kTurnNodes + (k + step) % kTurnNodes);
            };
            row[at(0)] = row[at(2)] = 1.0;
            row[at(1)] = -2.0;
            solver.believe(row, 0.0, is_shift(table) ? kShiftBend : kAngleBend);
        }
        VectorXd zero = VectorXd::Zero(size);
        add_table(zero, table, 0.0, 1.0);
        solver.believe(zero, 0.0, kAtZero);
    }
}

Layout lay_out(std::span<const TablePoint> points, const std::filesystem::path& file) {
    Layout layout;
    bool up = false;
    bool down = false;
    bool unknown = false;
    for (const TablePoint& p : points) {
        layout.target.emplace(p.target, layout.target.size());
        up = up || p.approach > 0;
        down = down || p.approach < 0;
        unknown = unknown || p.approach == 0;
    }
    if (layout.target.size() < kFewestTargets || points.size() < kFewestPoints) {
        refuse_fit(file, 0, "too few targets or points for a map of the table",
                   std::to_string(layout.target.size()) + " targets, " + std::to_string(points.size()) + " points",
                   "measure " + std::to_string(kFewestTargets) + " targets or more, " + std::to_string(kFewestPoints) +
                       " points or more");
    }
    if (!unknown && !(up && down)) {
        refuse_fit(file, 0, "every angle has been approached from the same side", "",
                   "approach angles from both sides, or leave dir_c out: backlash is not fitted then");
    }
    layout.backlash = !unknown;
    return layout;
}

/// The least certain correction of a place 0.2 m from the pivot.
double check_support(const MapSolver& solver, const Layout& layout, const AxisLine& axis, const Vec3& pivot,
                     const std::filesystem::path& file) {
    double worst = 0.0;
    double where = 0.0;
    for (int c = 0; c < 360; c += 15) {
        for (const Vec3& arm : {Vec3{kReach, 0.0, 0.0}, Vec3{0.0, kReach, 0.0}, Vec3{0.0, 0.0, kReach}}) {
            for (const VectorXd& row : motion_rows(layout, axis, pivot, pivot + arm, c, 1)) {
                const double sigma = solver.sigma_of(row);
                where = sigma > worst ? c : where;
                worst = std::max(worst, sigma);
            }
        }
    }
    if (!(worst <= kLargestMapSigma)) {
        refuse_fit(file, 0, "the points say too little about C near " + about(where) + " deg: sigma, um",
                   about(worst * 1e6),
                   "measure all round, with three targets or more that are well apart, in height too");
    }
    return worst;
}

void take(AxisMap& map, const MapSolver& solver, const Layout& layout, const AxisConfig& axis) {
    const auto on_grid = [](double v, double units) { return static_cast<std::int32_t>(std::llround(v * units)); };
    for (std::size_t k = 0; k < kTables; ++k) {
        const double value = solver.solution()[static_cast<Index>(k)];
        const bool angle = k < kTurnNodes;
        map.turn[k / kTurnNodes][k % kTurnNodes] = on_grid(angle ? value / kDegree : value, angle ? 1e9 : 1e12);
    }
    const double width =
        layout.backlash ? std::max(0.0, 2.0 * solver.solution()[static_cast<Index>(kTables)] / kDegree) : 0.0;
    map.backlash[index(Axis::c)] = on_grid(width, 1e9);
    map.take_up[index(Axis::c)] = width > 0.0 ? take_up_for(width, axis) : 0.0;
}

}  // namespace

FitQuality fit_table(CalibrationSet& set, const MachineConfig& machine, std::span<const TablePoint> points,
                     const std::filesystem::path& file) {
    const AxisLine& axis = turntable_axis(set);
    const Layout layout = lay_out(points, file);
    std::vector<Vec3> place(layout.target.size());
    std::vector<double> seen(layout.target.size());
    double height = 0.0;
    for (const TablePoint& p : points) {
        const std::size_t k = layout.target.at(p.target);
        place[k] = place[k] + (h_from_t(axis, p.c_deg).inverse() * Point<frame::H>{p.place}).v;
        seen[k] += 1.0;
        height += p.place.z / static_cast<double>(points.size());
    }
    for (std::size_t k = 0; k < place.size(); ++k) {
        place[k] = (1.0 / seen[k]) * place[k];
    }
    const Vec3& u = axis.direction.v;
    Vec3 pivot = axis.point.v + ((height - axis.point.v.z) / u.z) * u;
    pivot = {std::round(pivot.x * 1e6) / 1e6, std::round(pivot.y * 1e6) / 1e6, std::round(pivot.z * 1e6) / 1e6};

    MapSolver solver(layout.unknowns());
    believe(solver, layout);
    double sum_before = 0.0;
    for (const TablePoint& p : points) {
        const std::size_t k = layout.target.at(p.target);
        const Rigid<frame::H, frame::T> turn = h_from_t(axis, p.c_deg);
        const Vec3 r = (turn * Point<frame::T>{place[k]}).v;
        auto rows = motion_rows(layout, axis, pivot, r, p.c_deg, p.approach);
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                rows[i][static_cast<Index>(layout.places() + 3 * k + j)] = turn.rotation.row[i][j];
            }
            solver.measure(rows[i], p.place[i] - r[i], p.line);
            sum_before += std::pow(p.place[i] - r[i], 2);
        }
    }
    solver.solve();
    refuse_outlier(solver, file, 1.0);
    AxisMap map = axis_map_of(set);
    map.pivot = pivot;
    take(map, solver, layout, machine.axis[index(Axis::c)]);
    refuse_bad_map(map, machine, file);
    FitQuality quality;
    quality.points = points.size();
    quality.before_rms = std::sqrt(sum_before / static_cast<double>(points.size()));
    quality.residual_rms = solver.residual_rms() * std::sqrt(3.0);
    quality.residual_max = solver.residual_max();
    quality.worst_sigma = check_support(solver, layout, axis, pivot, file);
    Provenance provenance = set.axis_map ? set.axis_map->provenance : Provenance{};
    provenance.parents.push_back(file.filename().string());
    provenance.residual_rms = std::max(provenance.residual_rms, quality.residual_rms);
    provenance.time = set.time;
    set.axis_map = AxisMapRecord{map, provenance};
    return quality;
}

}  // namespace sc::host
