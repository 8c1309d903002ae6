// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/axis_map_fit.hpp"

#include <algorithm>
#include <cmath>

#include "host/calibration/map_solver.hpp"
#include "host/formats/text.hpp"

namespace sc::host {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::size_t kFewestPoints = 40;
/// Beliefs before any measurement: a correction is some 0.2 mm, and bends by some 10 µm from node to node.
constexpr double kCoefficientSigma = 200e-6;
constexpr double kBendSigma = 10e-6;
constexpr double kBacklashSigma = 1e-3;
constexpr double kRatioSigma = 0.05;
constexpr double kOverhang = 1e-3;  ///< of the tables beyond the travel
constexpr std::size_t kTables = 3 * kMapCoefficients;
constexpr int kSupportSteps = 6;

std::int32_t on_grid(double metres) { return static_cast<std::int32_t>(std::llround(metres * kPmPerMetre)); }

/// The approach of axis i is known for every point; refuses one side alone.
bool knows_backlash(std::span<const AxesPoint> points, std::size_t i, const std::filesystem::path& file) {
    const auto has = [&](int way) {
        return std::any_of(points.begin(), points.end(), [&](const AxesPoint& p) { return p.approach[i] == way; });
    };
    if (has(0)) {
        return false;
    }
    if (!has(1) || !has(-1)) {
        refuse_fit(file, 0, std::string("every point has been approached from the same side by axis ") + "XYZ"[i], "",
                   "approach places from both sides, or leave the column out: backlash is not fitted then");
    }
    return true;
}

/// Row i of p = A q: the ratios in the order of its columns (diagonal first), then the offset and half the backlash.
struct RowFit {
    std::vector<double> ratio;
    std::vector<double> sigma;
};

RowFit fit_row(std::span<const AxesPoint> points, std::size_t i, bool backlash) {
    const std::size_t ratios = 3 - i;
    MapSolver solver(ratios + 2);
    const auto size = static_cast<Index>(ratios + 2);
    for (Index k = 0; k < size; ++k) {
        solver.believe(VectorXd::Unit(size, k), 0.0, k < static_cast<Index>(ratios) ? kRatioSigma : kBacklashSigma);
    }
    for (const AxesPoint& p : points) {
        VectorXd row = VectorXd::Zero(size);
        for (std::size_t j = i; j < 3; ++j) {
            row[static_cast<Index>(j - i)] = p.reading[j];
        }
        row[size - 2] = 1.0;
        row[size - 1] = backlash ? -static_cast<double>(p.approach[i]) : 0.0;
        solver.measure(row, p.place[i] - p.reading[i], p.line);
    }
    solver.solve();
    RowFit fit;
    for (std::size_t k = 0; k < ratios; ++k) {
        fit.ratio.push_back(solver.solution()[static_cast<Index>(k)]);
        fit.sigma.push_back(solver.sigma_of(VectorXd::Unit(size, static_cast<Index>(k))));
    }
    return fit;
}

AxesRecord fit_matrix(std::span<const AxesPoint> points, const std::array<bool, 3>& backlash) {
    const RowFit x = fit_row(points, 0, backlash[0]);
    const RowFit y = fit_row(points, 1, backlash[1]);
    const RowFit z = fit_row(points, 2, backlash[2]);
    AxesRecord axes;
    axes.scale = {x.ratio[0], y.ratio[0], z.ratio[0]};
    axes.squareness_xy = x.ratio[1];
    axes.squareness_xz = x.ratio[2];
    axes.squareness_yz = y.ratio[1];
    const std::array<double, 6> sigma{x.sigma[1], x.sigma[2], y.sigma[1], x.sigma[0], y.sigma[0], z.sigma[0]};
    for (std::size_t k = 0; k < 6; ++k) {
        axes.covariance.at[k][k] = sigma[k] * sigma[k];
    }
    return axes;
}

/// Row of the three tables of one axis at nominal readings.
VectorXd table_row(const AxisMap& map, const Vec3& nominal, bool backlash, int approach) {
    VectorXd row = VectorXd::Zero(static_cast<Index>(kTables + (backlash ? 1 : 0)));
    for (std::size_t j = 0; j < 3; ++j) {
        const SplineCell cell = spline_cell(nominal[j], map.first[j], map.spacing[j], kMapNodes - 1);
        for (std::size_t k = 0; k < 4; ++k) {
            row[static_cast<Index>(j * kMapCoefficients + cell.first + k)] = cell.weight[k];
        }
    }
    if (backlash) {
        row[static_cast<Index>(kTables)] = approach;
    }
    return row;
}

void believe_tables(MapSolver& solver, std::size_t unknowns) {
    const auto size = static_cast<Index>(unknowns);
    for (std::size_t k = 0; k < unknowns; ++k) {
        solver.believe(VectorXd::Unit(size, static_cast<Index>(k)), 0.0,
                       k < kTables ? kCoefficientSigma : kBacklashSigma);
    }
    for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t k = 0; k + 2 < kMapCoefficients; ++k) {
            VectorXd row = VectorXd::Zero(size);
            const auto at = static_cast<Index>(j * kMapCoefficients + k);
            row[at] = row[at + 2] = 1.0;
            row[at + 1] = -2.0;
            solver.believe(row, 0.0, kBendSigma);
        }
    }
}

/// The least certain corrected place of axis i within the travel.
double check_support(const MapSolver& solver, const AxisMap& map, const MachineConfig& machine, std::size_t i,
                     bool backlash, const std::filesystem::path& file) {
    double worst = 0.0;
    Vec3 where;
    const auto at = [&](std::size_t j, int step) {
        const AxisConfig& axis = machine.axis[j];
        return axis.travel_min + (axis.travel_max - axis.travel_min) * step / kSupportSteps;
    };
    for (int a = 0; a <= kSupportSteps; ++a) {
        for (int b = 0; b <= kSupportSteps; ++b) {
            for (int c = 0; c <= kSupportSteps; ++c) {
                const Vec3 nominal{at(0, a), at(1, b), at(2, c)};
                const double sigma = solver.sigma_of(table_row(map, nominal, backlash, 1));
                if (sigma > worst) {
                    worst = sigma;
                    where = nominal;
                }
            }
        }
    }
    if (!(worst <= kLargestMapSigma)) {
        refuse_fit(file, 0,
                   std::string("the points say too little about ") + "xyz"[i] + " near (" + about(where.x * 1e3) +
                       ", " + about(where.y * 1e3) + ", " + about(where.z * 1e3) + ") mm: sigma, um",
                   about(worst * 1e6),
                   "measure along each axis over its whole travel, at several places of the others");
    }
    return worst;
}

void lay_out(AxisMap& map, const MachineConfig& machine) {
    for (std::size_t j = 0; j < 3; ++j) {
        const AxisConfig& axis = machine.axis[j];
        map.first[j] = std::floor((axis.travel_min - kOverhang) * 1e6) / 1e6;
        const double spacing = (axis.travel_max + kOverhang - map.first[j]) / static_cast<double>(kMapNodes - 1);
        map.spacing[j] = std::ceil(spacing * 1e7) / 1e7;
    }
}

}  // namespace

FitQuality fit_axes(CalibrationSet& set, const MachineConfig& machine, std::span<const AxesPoint> points,
                    const std::filesystem::path& file) {
    if (points.size() < kFewestPoints) {
        refuse_fit(file, 0, "too few points for a map of the axes", std::to_string(points.size()),
                   "measure " + std::to_string(kFewestPoints) + " or more");
    }
    std::array<bool, 3> backlash{};
    for (std::size_t i = 0; i < 3; ++i) {
        backlash[i] = knows_backlash(points, i, file);
    }
    CalibrationSet out = set;
    out.axes = fit_matrix(points, backlash);
    AxisMap map = axis_map_of(set);
    lay_out(map, machine);
    const Mat3 axis_from_h = compensation_of(out).axis_from_h;
    FitQuality quality;
    quality.points = points.size();
    double sum_before = 0.0;
    double sum_after = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t unknowns = kTables + (backlash[i] ? 1 : 0);
        MapSolver solver(unknowns);
        believe_tables(solver, unknowns);
        for (const AxesPoint& p : points) {
            const Vec3 nominal = axis_from_h * p.place;
            solver.measure(table_row(map, nominal, backlash[i], p.approach[i]), p.reading[i] - nominal[i], p.line);
            sum_before += std::pow(p.place[i] - p.reading[i], 2);
        }
        solver.solve();
        refuse_outlier(solver, file, 1.0);
        quality.worst_sigma = std::max(quality.worst_sigma, check_support(solver, map, machine, i, backlash[i], file));
        quality.residual_max = std::max(quality.residual_max, solver.residual_max());
        sum_after += std::pow(solver.residual_rms(), 2) * static_cast<double>(points.size());
        for (std::size_t k = 0; k < kTables; ++k) {
            map.linear[i][k / kMapCoefficients][k % kMapCoefficients] =
                on_grid(solver.solution()[static_cast<Index>(k)]);
        }
        const double width = backlash[i] ? 2.0 * solver.solution()[static_cast<Index>(kTables)] : 0.0;
        map.backlash[i] = std::max(0, on_grid(width));
        map.take_up[i] = map.backlash[i] > 0 ? take_up_for(width, machine.axis[i]) : 0.0;
    }
    quality.before_rms = std::sqrt(sum_before / static_cast<double>(points.size()));
    quality.residual_rms = std::sqrt(sum_after / static_cast<double>(points.size()));
    refuse_bad_map(map, machine, file);
    const Provenance provenance{{file.filename().string()}, quality.residual_rms, set.time, ""};
    out.axes->provenance = provenance;
    out.axis_map = AxisMapRecord{map, provenance};
    set = std::move(out);
    return quality;
}

}  // namespace sc::host
