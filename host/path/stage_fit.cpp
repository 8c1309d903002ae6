// SPDX-License-Identifier: Apache-2.0
#include "host/path/stage_fit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/SparseCholesky>

#include "shared/machine/galvo_field.hpp"

namespace sc::host {
namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;
using Entry = Eigen::Triplet<double>;

/// Of how the controller makes the stage follow: means over two boxes of so long.
constexpr double kSmoothing = 0.064;
constexpr double kKnotTime = 0.08;  ///< s between knots at the path's speed
constexpr double kShare = 0.5;
constexpr double kKept = 0.97;  ///< of each share: rounding, and what the solver leaves
constexpr double kFieldMargin = 2e-3;
constexpr double kDepthMargin = 0.5e-3;
constexpr double kTravelMargin = 0.6e-3;
constexpr int kSteps = 4000;
constexpr int kCheckEach = 50;
constexpr double kRelaxation = 1.6;
constexpr double kProximal = 1e-6;
constexpr double kCentring = 2e-3;
constexpr double kThird = 0.1;
constexpr double kConverged = 1e-4;

/// Weights of the four control points of the interval that holds a distance.
struct Weights {
    std::size_t first = 0;
    std::array<double, 4> w{};
};
Weights weights_at(double distance, double spacing, std::size_t count) {
    const double knots = std::clamp(distance / spacing, 0.0, static_cast<double>(count - 3));
    Weights found;
    found.first = std::min(static_cast<std::size_t>(knots), count - 4);
    const double x = knots - static_cast<double>(found.first);
    const double y = 1.0 - x;
    found.w = {y * y * y / 6.0, (3.0 * x * x * x - 6.0 * x * x + 4.0) / 6.0,
               (3.0 * y * y * y - 6.0 * y * y + 4.0) / 6.0, x * x * x / 6.0};
    return found;
}

/// One axis: rows within low … high, in shares of the rules.
struct Rows {
    Matrix matrix;
    Vector low;
    Vector high;
    std::vector<double> distance;  ///< of each row
    std::size_t reach_rows = 0;    ///< the first ones
    Matrix weight;                 ///< of the objective, and
    Vector pull;
};

/// `unit`: of the unknowns, and the reach where it is marked.
Rows rows_of(std::span<const StagePlace> places, std::size_t axis, std::size_t count, const StageRules& rules,
             double unit, double origin) {
    std::vector<Entry> entries;
    Rows rows;
    std::vector<double> due;
    for (const StagePlace& place : places) {
        for (const double back : {0.0, rules.lag}) {
            const Weights at = weights_at(place.distance - back, rules.spacing, count);
            // The window of depth is for what is marked on the way; right behind a hold the reach must do.
            const double reach = place.marked && back > 0.0 ? unit : rules.reach[axis];
            for (std::size_t i = 0; i < 4; ++i) {
                entries.emplace_back(static_cast<int>(due.size()), static_cast<int>(at.first + i),
                                     at.w[i] * unit / reach);
            }
            due.push_back((place.place[axis] - origin) / reach);
            rows.distance.push_back(place.distance);
        }
    }
    rows.reach_rows = due.size();
    const std::vector<Entry> centring = entries;
    // Differences of control points, in shares of the limits; unknowns are in units of the reach.
    const double rate = rules.speed / rules.spacing * unit;
    const double scale = rules.speed / rules.spacing;
    const MoveLimits& limits = rules.limits[axis];
    const std::array<double, 3> per{rate / limits.speed, rate * scale / limits.acceleration,
                                    rate * scale * scale / limits.jerk};
    constexpr std::array<std::array<double, 4>, 3> kDifference{
        {{-1.0, 1.0, 0.0, 0.0}, {1.0, -2.0, 1.0, 0.0}, {-1.0, 3.0, -3.0, 1.0}}};
    std::vector<Entry> smooth;
    std::size_t row = due.size();
    std::size_t smooth_row = 0;
    for (std::size_t order = 1; order <= 3; ++order) {
        for (std::size_t i = 0; i + order < count; ++i) {
            for (std::size_t k = 0; k <= order; ++k) {
                const double value = kDifference[order - 1][k] * per[order - 1];
                entries.emplace_back(static_cast<int>(row), static_cast<int>(i + k), value);
                if (order >= 2) {
                    const double weight = order == 2 ? 1.0 : kThird;
                    smooth.emplace_back(static_cast<int>(smooth_row), static_cast<int>(i + k), weight * value);
                }
            }
            rows.distance.push_back((static_cast<double>(i) - 1.0) * rules.spacing);
            smooth_row += order >= 2 ? 1 : 0;
            ++row;
        }
    }
    const double middle = 0.5 * (rules.low[axis] + rules.high[axis]) - origin;
    const double span = 0.5 * (rules.high[axis] - rules.low[axis]);
    const auto first_travel = static_cast<Eigen::Index>(row);
    for (std::size_t i = 0; i < count; ++i) {
        entries.emplace_back(static_cast<int>(row), static_cast<int>(i), unit / span);
        rows.distance.push_back((static_cast<double>(i) - 1.0) * rules.spacing);
        ++row;
    }
    const auto n = static_cast<int>(count);
    rows.matrix.resize(static_cast<int>(row), n);
    rows.matrix.setFromTriplets(entries.begin(), entries.end());
    rows.low = Vector::Constant(static_cast<int>(row), -1.0);
    rows.high = Vector::Constant(static_cast<int>(row), 1.0);
    const Eigen::Map<const Vector> places_due(due.data(), static_cast<int>(due.size()));
    rows.low.head(places_due.size()) += places_due;
    rows.high.head(places_due.size()) += places_due;
    rows.low.tail(rows.low.size() - first_travel).array() += middle / span;
    rows.high.tail(rows.high.size() - first_travel).array() += middle / span;
    Matrix centre(static_cast<int>(due.size()), n);
    centre.setFromTriplets(centring.begin(), centring.end());
    Matrix differences(static_cast<int>(smooth_row), n);
    differences.setFromTriplets(smooth.begin(), smooth.end());
    const double share = kCentring * static_cast<double>(count) / static_cast<double>(due.size());
    rows.weight = Matrix(differences.transpose()) * differences + share * (Matrix(centre.transpose()) * centre);
    rows.pull = share * (centre.transpose() * places_due);
    return rows;
}

struct Solved {
    Vector x;
    double worst = 0.0;
    std::size_t row = 0;
};

void judge(const Rows& rows, Solved& solved) {
    const Vector z = rows.matrix * solved.x;
    solved.worst = 0.0;
    for (int i = 0; i < static_cast<int>(z.size()); ++i) {
        const double middle = 0.5 * (rows.low[i] + rows.high[i]);
        const double share = std::abs(z[i] - middle);
        if (share > solved.worst) {
            solved.worst = share;
            solved.row = static_cast<std::size_t>(i);
        }
    }
}

Solved solve(const Rows& rows) {
    const auto n = static_cast<int>(rows.matrix.cols());
    const auto m = static_cast<int>(rows.matrix.rows());
    Matrix identity(n, n);
    identity.setIdentity();
    const Matrix normal = Matrix(rows.matrix.transpose()) * rows.matrix;
    double penalty = 1.0;
    Eigen::SimplicialLDLT<Matrix> factor;
    const auto refactor = [&] {
        const Matrix sum = rows.weight + kProximal * identity + penalty * normal;
        factor.compute(sum);
    };
    refactor();
    Solved solved{.x = Vector::Zero(n)};
    Vector z = (0.5 * (rows.low + rows.high)).eval();
    Vector y = Vector::Zero(m);
    for (int step = 1; step <= kSteps; ++step) {
        const Vector right = rows.pull + kProximal * solved.x + rows.matrix.transpose() * (penalty * z - y);
        solved.x = factor.solve(right);
        const Vector reached = rows.matrix * solved.x;
        const Vector mixed = kRelaxation * reached + (1.0 - kRelaxation) * z;
        const Vector before = z;
        z = (mixed + y / penalty).cwiseMax(rows.low).cwiseMin(rows.high);
        y += penalty * (mixed - z);
        if (step % kCheckEach != 0) {
            continue;
        }
        const double primal = (reached - z).lpNorm<Eigen::Infinity>();
        const double dual = penalty * (rows.matrix.transpose() * (z - before)).lpNorm<Eigen::Infinity>();
        if (primal < kConverged && dual < kConverged) {
            break;
        }
        const double ratio = std::sqrt((primal + 1e-12) / (dual + 1e-12));
        if (step % (4 * kCheckEach) == 0 && (ratio > 5.0 || ratio < 0.2)) {
            penalty = std::clamp(penalty * std::clamp(ratio, 0.1, 10.0), 1e-4, 1e6);
            refactor();
        }
    }
    judge(rows, solved);
    return solved;
}

/// Travel of an axis, less the keep-out volumes that bar one end of it wherever the other axes are.
std::pair<double, double> free_travel(std::size_t axis, const MachineConfig& machine) {
    double low = machine.axis[axis].travel_min;
    double high = machine.axis[axis].travel_max;
    for (std::size_t k = 0; k < std::min<std::size_t>(machine.keep_out_count, kKeepOutCapacity); ++k) {
        const KeepOut& box = machine.keep_out[k];
        bool bars = true;
        for (std::size_t other = 0; other < 3; ++other) {
            const AxisConfig& travel = machine.axis[other];
            bars =
                bars && (other == axis || (box.min[other] <= travel.travel_min && box.max[other] >= travel.travel_max));
        }
        if (bars && box.min[axis] <= machine.axis[axis].travel_min) {
            low = std::max(low, box.max[axis]);
        } else if (bars && box.max[axis] >= machine.axis[axis].travel_max) {
            high = std::min(high, box.min[axis]);
        }
    }
    return {low, high};
}

}  // namespace

StageRules stage_rules(double speed, const MachineConfig& machine, double depth) {
    StageRules rules;
    rules.speed = speed;
    rules.spacing = std::clamp(std::ceil(speed * kKnotTime * 1e6) * 1e-6, 1.1e-3, 0.9);
    rules.lag = speed * (kSmoothing + 1e-9 * static_cast<double>(machine.axis[index(Axis::x)].latency_ns));
    const double half = machine.galvo.half_field.si() - kFieldMargin;
    rules.reach = {half, std::min(depth, GalvoField::kDepthMost - kDepthMargin), half};
    for (std::size_t i = 0; i < 3; ++i) {
        const AxisConfig& axis = machine.axis[i];
        const auto [low, high] = free_travel(i, machine);
        (i == 0 ? rules.low.x : i == 1 ? rules.low.y : rules.low.z) = low + kTravelMargin;
        (i == 0 ? rules.high.x : i == 1 ? rules.high.y : rules.high.z) = high - kTravelMargin;
        MoveLimits& limits = rules.limits[i];
        limits.speed = kKept * kShare * axis.speed;
        limits.acceleration = std::min(kShare * axis.acceleration, axis.acceleration - limits.speed / kSmoothing);
        // What is left of the jerk goes to both terms that the curve's bends make.
        const double left = axis.jerk - 2.0 * limits.speed / (kSmoothing * kSmoothing);
        limits.acceleration = kKept * std::min(limits.acceleration, 0.5 * left * kSmoothing / 3.0);
        limits.jerk = kKept * std::min(kShare * axis.jerk, 0.5 * left);
    }
    return rules;
}

StageFit fit_stage(std::span<const StagePlace> places, std::size_t count, const StageRules& rules) {
    StageFit fit;
    fit.control.resize(count);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        double origin = 0.0;
        for (const StagePlace& place : places) {
            origin += place.place[axis] / static_cast<double>(places.size());
        }
        std::vector<double> units{rules.reach[axis]};
        if (axis == index(Axis::y)) {
            units.insert(units.begin(), kDepthWindows.begin(), kDepthWindows.end());
        }
        Rows rows;
        Solved solved;
        double unit = 0.0;
        for (const double tried : units) {
            unit = tried;
            rows = rows_of(places, axis, count, rules, unit, origin);
            solved = solve(rows);
            if (solved.worst <= 1.0 + kStageSlack) {
                break;
            }
        }
        fit.depth_window = axis == index(Axis::y) ? unit : fit.depth_window;
        for (std::size_t i = 0; i < count; ++i) {
            const double value = origin + unit * solved.x[static_cast<int>(i)];
            (axis == 0 ? fit.control[i].x : axis == 1 ? fit.control[i].y : fit.control[i].z) = value;
        }
        if (solved.worst > fit.worst) {
            fit.worst = solved.worst;
            fit.worst_distance = rows.distance[solved.row];
            fit.by_reach = solved.row < rows.reach_rows;
        }
    }
    return fit;
}

Vec3 stage_at(std::span<const Vec3> control, double spacing, double distance) {
    const Weights at = weights_at(distance, spacing, control.size());
    Vec3 place{};
    for (std::size_t i = 0; i < 4; ++i) {
        place = place + at.w[i] * control[at.first + i];
    }
    return place;
}

}  // namespace sc::host
