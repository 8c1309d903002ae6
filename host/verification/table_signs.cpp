// SPDX-License-Identifier: Apache-2.0
#include "host/verification/table_signs.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sc::host {

namespace {

constexpr double kRareMean = 1e-3;
constexpr double kRareGridLog10 = -4.0;
constexpr double kWithinDigits = 1.1;  ///< of the grid, in last digits
constexpr double kPlaneDigits = 1.0;   ///< rms that counts as rounding alone
constexpr double kPlaneGain = 5.0;     ///< and the column must vary by that much more
constexpr std::size_t kFewestForPlane = 5;
constexpr std::array<int, 7> kStepDigits{4, 5, 10, 20, 25, 50, 100};

double mm(double metres) { return 1e3 * metres; }
double um(double metres) { return 1e6 * metres; }
char name_of_axis(std::size_t axis) { return "xyz"[axis]; }

Vec3 deviation(const TableRow& row) { return row.measured.v - row.truth.v; }

/// log10 of the probability of `hits` or more in `trials` of probability p each.
double log10_binomial_tail(std::size_t hits, std::size_t trials, double p) {
    const double log_p = std::log(p);
    const double log_q = std::log1p(-p);
    const auto n = static_cast<double>(trials);
    double sum = 0.0;
    double largest = -1e300;
    std::vector<double> logs;
    for (std::size_t k = hits; k <= trials; ++k) {
        const auto kk = static_cast<double>(k);
        logs.push_back(std::lgamma(n + 1.0) - std::lgamma(kk + 1.0) - std::lgamma(n - kk + 1.0) + kk * log_p +
                       (n - kk) * log_q);
        largest = std::max(largest, logs.back());
    }
    for (const double l : logs) {
        sum += std::exp(l - largest);
    }
    return (largest + std::log(sum)) / std::numbers::ln10;
}

/// Values of one face that lie within the last digit of a grid, at the offset that suits most of them.
std::size_t hits_on_grid(const std::vector<double>& values, double step, double digit) {
    std::size_t best = 0;
    for (const double origin : values) {
        const auto on = std::ranges::count_if(
            values, [&](double v) { return std::abs(std::remainder(v - origin, step)) <= kWithinDigits * digit; });
        best = std::max(best, static_cast<std::size_t>(on));
    }
    return best;
}

/// `faces`: the values of one column, face by face. The value at a face's origin is on its grid by choice.
std::optional<JogGrid> grid_of(const std::vector<std::vector<double>>& faces, double digit) {
    std::optional<JogGrid> best;
    for (const int digits : kStepDigits) {
        JogGrid grid;
        grid.step = digits * digit;
        std::size_t chosen = 0;
        for (const std::vector<double>& values : faces) {
            grid.within += hits_on_grid(values, grid.step, digit);
            grid.values += values.size();
            ++chosen;
        }
        const double p = 3.0 / digits;
        if (grid.values <= chosen || p >= 1.0) {
            continue;
        }
        // One of `digits` offsets was chosen on each face, and one of the steps.
        grid.log10_chance = log10_binomial_tail(grid.within - chosen, grid.values - chosen, p) +
                            static_cast<double>(chosen) * std::log10(3.0) + std::log10(kStepDigits.size());
        if (grid.log10_chance < kRareGridLog10 && (!best || grid.log10_chance < best->log10_chance)) {
            best = grid;
        }
    }
    return best;
}

void find_grids(const PrintedTable& table, TableAssessment& out) {
    for (const bool of_truth : {false, true}) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            std::map<double, std::vector<double>> faces;
            for (const TableRow& row : table.table.rows) {
                faces[row.face_deg].push_back(of_truth ? row.truth.v[axis] : deviation(row)[axis]);
            }
            std::vector<std::vector<double>> columns;
            for (const auto& face : faces) {
                const auto [least, most] = std::ranges::minmax(face.second);
                if (most - least > 20.0 * table.digit) {
                    columns.push_back(face.second);
                }
            }
            if (auto grid = grid_of(columns, table.digit)) {
                grid->axis = name_of_axis(axis);
                grid->of_truth = of_truth;
                out.grids.push_back(*grid);
                out.warnings.push_back(
                    {TableFinding::jog_grid,
                     fmt::format("{} stands on a grid of {:.4g} mm ({} of {} values within the last digit; by chance "
                                 "1 in 10^{:.0f}): the true places were reached in steps of that size, not measured "
                                 "finer",
                                 of_truth ? fmt::format("the true {}", grid->axis) : fmt::format("d{}", grid->axis),
                                 mm(grid->step), grid->within, grid->values, -grid->log10_chance),
                     {}});
            }
        }
    }
}

void find_zeroed_means(TableAssessment& out) {
    std::array<double, 3> joint{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::vector<double> chances;
        std::vector<std::string> means;
        for (const TableFace& face : out.faces) {
            chances.push_back(face.mean_chance[axis]);
            means.push_back(fmt::format("{:+.2f}", um(face.figures.mean[axis])));
        }
        joint.at(axis) = joint_chance(chances);
        if (joint.at(axis) < kRareMean) {
            out.warnings.push_back(
                {TableFinding::zeroed_mean,
                 fmt::format("the faces' means of d{} are {} um, where scatter allows some {:.0f} um: by chance 1 in "
                             "{:.2g}. A shift was taken out of each face, so the table cannot show an offset of the "
                             "frame or of the turntable's axis in {}",
                             name_of_axis(axis), fmt::join(means, ", "),
                             um(out.all.rms[axis]) /
                                 std::sqrt(static_cast<double>(out.all.points) / static_cast<double>(out.faces.size())),
                             1.0 / joint.at(axis), name_of_axis(axis)),
                 {}});
        }
    }
    out.zeroed_chance = {joint[0], joint[1], joint[2]};
}

void find_dependent_columns(TableAssessment& out) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::size_t exact = 0;
        std::size_t judged = 0;
        std::vector<std::string> left;
        for (const TableFace& face : out.faces) {
            if (face.figures.points < kFewestForPlane) {
                continue;
            }
            ++judged;
            const double spread = std::sqrt(std::max(0.0, face.figures.rms[axis] * face.figures.rms[axis] -
                                                              face.figures.mean[axis] * face.figures.mean[axis]));
            const double rms = face.plane.at(axis).rms;
            exact += rms <= kPlaneDigits * out.digit && spread >= kPlaneGain * out.digit ? 1 : 0;
            left.push_back(fmt::format("{:.2f}", um(rms)));
        }
        if (exact > 0) {
            const std::string others = axis == 0 ? "y, z" : (axis == 1 ? "x, z" : "x, y");
            out.warnings.push_back(
                {TableFinding::dependent_column,
                 fmt::format("d{} is a plane over {} on {} of {} faces ({} um rms off it, as rounding leaves): {} was "
                             "not measured by itself",
                             name_of_axis(axis), others, exact, judged, fmt::join(left, ", "), name_of_axis(axis)),
                 {}});
        }
        if (out.all.rms[axis] == 0.0) {
            out.warnings.push_back(
                {TableFinding::copied_column,
                 fmt::format("true and measured {} are the same throughout: one of them is a copy", name_of_axis(axis)),
                 {}});
        }
    }
}

void find_arithmetic(const PrintedTable& table, TableAssessment& out) {
    const double half = 0.5 * table.digit;
    std::vector<int> by_rounding;
    std::vector<int> wrong;
    std::size_t reversed = 0;
    std::size_t large = 0;
    double worst = 0.0;
    for (std::size_t i = 0; i < table.deviations.size(); ++i) {
        const Vec3 d = deviation(table.table.rows[i]);
        double off = 0.0;
        double off_reversed = 0.0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            off = std::max(off, std::abs(d[axis] - table.deviations[i][axis]));
            off_reversed = std::max(off_reversed, std::abs(d[axis] + table.deviations[i][axis]));
        }
        const bool big = norm(d) > 4.0 * table.digit;
        large += big ? 1 : 0;
        reversed += big && off_reversed < off ? 1 : 0;
        worst = std::max(worst, off);
        if (off > half) {
            (off > 3.0 * half ? wrong : by_rounding).push_back(table.table.rows[i].line);
        }
    }
    if (large > 0 && 2 * reversed > large) {
        out.warnings.push_back(
            {TableFinding::reversed, "the printed deviations are true - measured; here measured - true is shown", {}});
    } else if (!wrong.empty()) {
        const std::size_t rows = wrong.size();
        out.warnings.push_back({TableFinding::arithmetic,
                                fmt::format("{} rows print deviations that are not m - t, by up to {:.4g} mm; the "
                                            "values of m and t are used",
                                            rows, mm(worst)),
                                std::move(wrong)});
    }
    if (!by_rounding.empty() && 2 * reversed <= large) {
        const std::size_t rows = by_rounding.size();
        out.warnings.push_back({TableFinding::arithmetic,
                                fmt::format("{} rows print deviations that differ from m - t by the last digit: they "
                                            "were computed before rounding",
                                            rows),
                                std::move(by_rounding)});
    }
}

void find_printed_maxima(const std::vector<PrintedMaximum>& maxima, TableAssessment& out) {
    const double allowed = 1.5 * out.digit;
    const auto compare = [&](const PrintedMaximum& printed, const std::string& what, double stated, double found,
                             int marker) {
        if (std::abs(std::abs(stated) - std::abs(found)) > allowed) {
            out.warnings.push_back(
                {TableFinding::printed_maximum,
                 fmt::format("the printed largest {} of face {:.6g} is {:.3f} mm; marker {} has "
                             "{:.3f} mm",
                             what, printed.face_deg, mm(std::abs(stated)), marker, mm(std::abs(found))),
                 {printed.line}});
        }
    };
    for (const PrintedMaximum& printed : maxima) {
        const auto face = std::ranges::find(out.faces, printed.face_deg, &TableFace::face_deg);
        if (face == out.faces.end()) {
            continue;
        }
        const DeviationFigures& f = face->figures;
        std::size_t worst = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            worst = std::abs(f.largest[axis]) > std::abs(f.largest[worst]) ? axis : worst;
            if (printed.axis.at(axis)) {
                compare(printed, fmt::format("d{}", name_of_axis(axis)), *printed.axis.at(axis), f.largest[axis],
                        f.largest_no.at(axis));
            }
        }
        if (printed.any) {
            compare(printed, fmt::format("deviation (d{})", name_of_axis(worst)), *printed.any, f.largest[worst],
                    f.largest_no.at(worst));
        }
    }
}

}  // namespace

std::string_view name_of(TableFinding finding) noexcept {
    switch (finding) {
        case TableFinding::arithmetic: return "arithmetic";
        case TableFinding::reversed: return "reversed";
        case TableFinding::printed_maximum: return "printed_maximum";
        case TableFinding::zeroed_mean: return "zeroed_mean";
        case TableFinding::jog_grid: return "jog_grid";
        case TableFinding::dependent_column: return "dependent_column";
        case TableFinding::copied_column: return "copied_column";
        case TableFinding::few_points: return "few_points";
    }
    return "";
}

double mean_chance(double mean, double rms, std::size_t count, double digit) noexcept {
    const double variance = rms * rms - mean * mean;
    const auto n = static_cast<double>(count);
    if (count < 3 || !(variance > digit * digit)) {
        return 1.0;
    }
    const double error = std::sqrt(variance / (n - 1.0));
    // A mean of rounded values is itself known to that much only.
    const double distance = std::max(std::abs(mean), digit / std::sqrt(12.0 * n));
    return std::erf(distance / error / std::numbers::sqrt2);
}

double joint_chance(const std::vector<double>& chances) noexcept {
    double half = 0.0;
    for (const double p : chances) {
        half -= std::log(std::max(p, 1e-300));
    }
    // Survival of chi-squared with 2 k degrees of freedom at 2·half.
    double term = 1.0;
    double sum = 1.0;
    for (std::size_t k = 1; k < chances.size(); ++k) {
        term *= half / static_cast<double>(k);
        sum += term;
    }
    return chances.empty() ? 1.0 : std::min(1.0, std::exp(-half) * sum);
}

void find_signs(const PrintedTable& table, const std::vector<PrintedMaximum>& maxima, TableAssessment& assessment) {
    for (const TableFace& face : assessment.faces) {
        if (face.figures.points < 4) {
            assessment.warnings.push_back({TableFinding::few_points,
                                           fmt::format("face {:.6g} has {} points: too few for a fit of its own",
                                                       face.face_deg, face.figures.points),
                                           {}});
        }
    }
    find_arithmetic(table, assessment);
    find_printed_maxima(maxima, assessment);
    find_zeroed_means(assessment);
    find_grids(table, assessment);
    find_dependent_columns(assessment);
}

}  // namespace sc::host
