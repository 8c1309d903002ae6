// SPDX-License-Identifier: Apache-2.0
#include "host/verification/table_check.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include <Eigen/Dense>

#include "host/verification/table_signs.hpp"

namespace sc::host {

namespace {

constexpr std::size_t kFewestForFit = 4;

using Points = Eigen::Matrix3Xd;

Eigen::Vector3d eigen(const Vec3& v) { return {v.x, v.y, v.z}; }
Vec3 plain(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

struct Places {
    Points measured;
    Points truth;
    std::vector<int> no;
    [[nodiscard]] Points deviation() const { return measured - truth; }
};

Places places_of(std::span<const TableRow> rows) {
    Places out{Points(3, rows.size()), Points(3, rows.size()), {}};
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto column = static_cast<Eigen::Index>(i);
        out.measured.col(column) = eigen(rows[i].measured.v);
        out.truth.col(column) = eigen(rows[i].truth.v);
        out.no.push_back(rows[i].no);
    }
    return out;
}

DeviationFigures figures_of(const Points& d, const std::vector<int>& no) {
    DeviationFigures out;
    const auto count = static_cast<double>(d.cols());
    out.points = static_cast<std::size_t>(d.cols());
    Eigen::Vector3d largest;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        Eigen::Index at = 0;
        d.row(axis).cwiseAbs().maxCoeff(&at);
        largest(axis) = d(axis, at);
        out.largest_no.at(static_cast<std::size_t>(axis)) = no.at(static_cast<std::size_t>(at));
    }
    out.largest = plain(largest);
    out.rms = plain((d.rowwise().squaredNorm() / count).cwiseSqrt());
    out.mean = plain(d.rowwise().mean());
    Eigen::Index at = 0;
    out.max_3d = d.colwise().norm().maxCoeff(&at);
    out.max_3d_no = no.at(static_cast<std::size_t>(at));
    out.rms_3d = std::sqrt(d.squaredNorm() / count);
    return out;
}

/// What the rotation and shift that bring `from` nearest to `to` leave over (Kabsch; Arun, Huang, Blostein 1987).
Points left_by_rigid(const Points& from, const Points& to) {
    const Eigen::Vector3d from_middle = from.rowwise().mean();
    const Eigen::Vector3d to_middle = to.rowwise().mean();
    const Points a = from.colwise() - from_middle;
    const Points b = to.colwise() - to_middle;
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(b * a.transpose(), Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d sign = Eigen::Vector3d::Ones();
    sign.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
    return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose() * a - b;
}

Points left_by_affine(const Points& from, const Points& to) {
    Eigen::MatrixXd design(from.cols(), 4);
    design.leftCols<3>() = (from.colwise() - Eigen::Vector3d(from.rowwise().mean())).transpose();
    design.col(3).setOnes();
    const Eigen::MatrixXd solution = design.colPivHouseholderQr().solve(to.transpose());
    return (design * solution).transpose() - to;
}

GlobalFit global_fit(const Points& left, double squares) {
    return {.rms_3d = std::sqrt(left.squaredNorm() / static_cast<double>(left.cols())),
            .max_3d = left.colwise().norm().maxCoeff(),
            .removed = squares > 0.0 ? 1.0 - left.squaredNorm() / squares : 0.0};
}

PlaneOfColumn plane_of(const Places& places, Eigen::Index axis) {
    const Eigen::Index first = axis == 0 ? 1 : 0;
    const Eigen::Index second = axis == 2 ? 1 : 2;
    const Points centred = places.measured.colwise() - Eigen::Vector3d(places.measured.rowwise().mean());
    Eigen::MatrixXd design(centred.cols(), 3);
    design.col(0).setOnes();
    design.col(1) = centred.row(first);
    design.col(2) = centred.row(second);
    const Eigen::VectorXd column = places.deviation().row(axis);
    const Eigen::Vector3d solution = design.colPivHouseholderQr().solve(column);
    return {.offset = solution(0),
            .slope = {solution(1), solution(2)},
            .rms = std::sqrt((column - design * solution).squaredNorm() / static_cast<double>(column.size()))};
}

/// Faces one after another, as they first appear.
std::vector<std::vector<TableRow>> by_face(const std::vector<TableRow>& rows) {
    std::vector<std::vector<TableRow>> out;
    for (const TableRow& row : rows) {
        const auto same = std::ranges::find_if(
            out, [&row](const std::vector<TableRow>& face) { return face.front().face_deg == row.face_deg; });
        if (same == out.end()) {
            out.push_back({row});
        } else {
            same->push_back(row);
        }
    }
    return out;
}

double quantile_95(std::vector<double> values) {
    std::ranges::sort(values);
    const double place = 0.95 * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return values[below] + (place - std::floor(place)) * (values[above] - values[below]);
}

TableFace face_of(const std::vector<TableRow>& rows, double digit, Points& left) {
    const Places places = places_of(rows);
    TableFace out;
    out.face_deg = rows.front().face_deg;
    out.figures = figures_of(places.deviation(), places.no);
    left = rows.size() >= kFewestForFit ? left_by_rigid(places.measured, places.truth) : places.deviation();
    out.after_fit = figures_of(left, places.no);
    for (Eigen::Index axis = 0; rows.size() >= kFewestForFit && axis < 3; ++axis) {
        out.plane.at(static_cast<std::size_t>(axis)) = plane_of(places, axis);
    }
    const DeviationFigures& f = out.figures;
    out.mean_chance = {mean_chance(f.mean.x, f.rms.x, f.points, digit), mean_chance(f.mean.y, f.rms.y, f.points, digit),
                       mean_chance(f.mean.z, f.rms.z, f.points, digit)};
    return out;
}

}  // namespace

TableAssessment assess_table(const PrintedTable& table, const std::vector<PrintedMaximum>& maxima) {
    TableAssessment out;
    out.digit = table.digit;
    const Places all = places_of(table.table.rows);
    const double squares = all.deviation().squaredNorm();
    out.all = figures_of(all.deviation(), all.no);
    double left_squares = 0.0;
    double in_plane_squares = 0.0;
    double in_plane_freedom = 0.0;  // a turn and two shifts are fitted on each face
    for (const std::vector<TableRow>& rows : by_face(table.table.rows)) {
        Points left;
        out.faces.push_back(face_of(rows, out.digit, left));
        left_squares += left.squaredNorm();
        in_plane_freedom += std::max(1.0, 2.0 * static_cast<double>(rows.size()) - 3.0);
        in_plane_squares += left.row(0).squaredNorm() + left.row(2).squaredNorm();
    }
    const auto count = static_cast<double>(all.measured.cols());
    out.pooled_3d = std::sqrt(left_squares / count);
    out.removed_by_faces = squares > 0.0 ? 1.0 - left_squares / squares : 0.0;
    out.in_plane_sigma = std::sqrt(in_plane_squares / in_plane_freedom);
    std::vector<double> in_plane;
    const Points deviation = all.deviation();
    for (Eigen::Index i = 0; i < deviation.cols(); ++i) {
        in_plane.push_back(std::abs(deviation(0, i)));
        in_plane.push_back(std::abs(deviation(2, i)));
    }
    out.in_plane_95 = quantile_95(in_plane);
    if (all.measured.cols() >= 3) {
        out.rigid = global_fit(left_by_rigid(all.measured, all.truth), squares);
    }
    if (all.measured.cols() >= 5) {
        out.affine = global_fit(left_by_affine(all.measured, all.truth), squares);
    }
    find_signs(table, maxima, out);
    return out;
}

}  // namespace sc::host
