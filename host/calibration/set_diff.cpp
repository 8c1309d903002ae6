// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/set_diff.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>

#include "host/calibration/galvo_model.hpp"
#include "host/calibration/motion.hpp"
#include "host/calibration/transforms.hpp"
#include "host/formats/calibration_records.hpp"
#include "shared/machine/machine.hpp"

namespace sc::host {

namespace {

constexpr double kBeforeAxis = 0.18;
constexpr double kFieldCorner = 0.02;

template <std::size_t N>
Eigen::MatrixXd matrix_of(const Covariance<N>& covariance) {
    Eigen::MatrixXd out(N, N);
    for (std::size_t i = 0; i < N; ++i) {
        for (std::size_t j = 0; j < N; ++j) {
            out(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = covariance.at[i][j];
        }
    }
    return out;
}

/// Survival of chi-squared with k degrees of freedom (Wilson and Hilferty).
double chance_of(double chi_squared, double k) {
    const double part = 2.0 / (9.0 * k);
    return 0.5 * std::erfc((std::cbrt(chi_squared / k) - (1.0 - part)) / std::sqrt(2.0 * part));
}

template <std::size_t N>
void weigh(RecordDiff& out, const Eigen::VectorXd& delta, const Covariance<N>& a, const Covariance<N>& b) {
    const Eigen::MatrixXd sum = matrix_of(a) + matrix_of(b);
    // Units differ by far: solved as a correlation matrix.
    const Eigen::VectorXd scale = sum.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::VectorXd scaled = scale.cwiseProduct(delta);
    const double chi = scaled.dot((scale.asDiagonal() * sum * scale.asDiagonal()).ldlt().solve(scaled));
    out.sigmas = std::sqrt(chi / static_cast<double>(N));
    out.chance = chance_of(chi, static_cast<double>(N));
}

Motion motion_of(const TransformRecord& record) { return {to_eigen(record.rotation), to_eigen(record.translation)}; }

RecordDiff diff(const TransformRecord& a, const TransformRecord& b, const Vec3& at) {
    RecordDiff out{.id = a.id};
    const Motion change = motion_of(b) * motion_of(a).inverse();
    const Eigen::Vector3d turn = log_turn(change.r);
    Eigen::VectorXd xi(6);
    xi << turn, change.t;  // T_b = Exp(ξ) T_a, with rotation and shift apart: to first order the same
    out.turn = turn.norm();
    const bool in_h = a.id.starts_with("h_from_");
    const Eigen::Vector3d place = in_h ? to_eigen(at) : to_eigen(a.translation);
    const Eigen::Vector3d moved = change * place - place;
    out.place = moved.norm();
    if (in_h) {
        out.moves = to_vec(moved);
    }
    weigh(out, xi, a.covariance, b.covariance);
    return out;
}

RecordDiff diff(const AxisRecord& a, const AxisRecord& b, const Vec3& at) {
    RecordDiff out{.id = "turntable"};
    // Both where the axis meets the plane of a's point.
    const Vec3& d = b.line.direction.v;
    const Vec3 shifted = b.line.point.v + ((a.line.point.v.z - b.line.point.v.z) / d.z) * d;
    const Vec3 lean = d - a.line.direction.v;
    const Vec3 shift = shifted - a.line.point.v;
    Eigen::VectorXd delta(4);
    delta << shift.x, shift.y, lean.x, lean.y;
    out.turn = std::hypot(lean.x, lean.y);
    const double up = (at.z - a.line.point.v.z);
    out.place = std::hypot(shift.x + up * lean.x, shift.y + up * lean.y);
    Vec3 worst;
    for (const double face : {90.0, 180.0, 270.0}) {
        const Point<frame::T> place{at};
        const Vec3 moved =
            (h_from_t(b.line, c_of_face(face)) * place).v - (h_from_t(a.line, c_of_face(face)) * place).v;
        worst = norm(moved) > norm(worst) ? moved : worst;
    }
    out.moves = worst;
    weigh(out, delta, a.covariance, b.covariance);
    return out;
}

RecordDiff diff(const AxesRecord& a, const AxesRecord& b, const Vec3& at) {
    RecordDiff out{.id = "axes"};
    const std::array<double, 6> delta{b.squareness_xy - a.squareness_xy, b.squareness_xz - a.squareness_xz,
                                      b.squareness_yz - a.squareness_yz, b.scale[0] - a.scale[0],
                                      b.scale[1] - a.scale[1],           b.scale[2] - a.scale[2]};
    // The controller commands A⁻¹ p, so a larger estimate brings the focus back by δA p.
    out.moves =
        -Vec3{delta[0] * at.y + delta[1] * at.z + delta[3] * at.x, delta[2] * at.z + delta[4] * at.y, delta[5] * at.z};
    out.turn = std::max({std::abs(delta[0]), std::abs(delta[1]), std::abs(delta[2])});
    weigh(out, Eigen::Map<const Eigen::Matrix<double, 6, 1>>(delta.data()), a.covariance, b.covariance);
    return out;
}

RecordDiff diff(const GalvoRecord& a, const GalvoRecord& b, const Vec3& /*at*/) {
    RecordDiff out{.id = "galvo"};
    std::array<double, 6> delta{b.offset[0] - a.offset[0], b.offset[1] - a.offset[1]};
    for (std::size_t i = 0; i < 4; ++i) {
        delta.at(i + 2) = b.matrix.at(i) - a.matrix.at(i);
    }
    out.place = std::hypot(delta[0], delta[1]);
    weigh(out, Eigen::Map<const Eigen::Matrix<double, 6, 1>>(delta.data()), a.covariance, b.covariance);
    return out;
}

RecordDiff diff(const GalvoFieldRecord& a, const GalvoFieldRecord& b, const Vec3& /*at*/) {
    RecordDiff out{.id = "galvo_field"};
    const GalvoModel model_a = GalvoModel::from(a);
    const GalvoModel model_b = GalvoModel::from(b);
    // The beam is sent by b's inverse where a says it lands; corners and middle.
    Vec3 worst;
    for (const FieldPlace& command :
         {FieldPlace{0.0, 0.0}, FieldPlace{kFieldCorner, kFieldCorner}, FieldPlace{-kFieldCorner, kFieldCorner},
          FieldPlace{kFieldCorner, -kFieldCorner}, FieldPlace{-kFieldCorner, -kFieldCorner}}) {
        const FieldPlace p = model_a.land(command, 0.0);
        const FieldPlace q = model_b.land(command, 0.0);
        const Vec3 moved{p[0] - q[0], 0.0, p[1] - q[1]};
        worst = norm(moved) > norm(worst) ? moved : worst;
    }
    out.moves = worst;
    Eigen::VectorXd delta(GalvoModel::kParameters);
    for (std::size_t i = 0; i < GalvoModel::kParameters; ++i) {
        delta(static_cast<Eigen::Index>(i)) = b.value.at(i) - a.value.at(i);
    }
    weigh(out, delta, a.covariance, b.covariance);
    return out;
}

template <class Record>
RecordDiff diff(const Record& /*a*/, const Record& /*b*/, const Vec3& /*at*/) {
    return {};
}

template <class Record>
void compare(std::vector<RecordDiff>& out, const std::string& id, const std::optional<Record>& a,
             const std::optional<Record>& b, const Vec3& at) {
    if (!a && !b) {
        return;
    }
    RecordDiff record;
    if (a && b && *a != *b) {
        record = diff(*a, *b, at);
        record.change = RecordChange::changed;
    } else if (!a || !b) {
        record.change = a ? RecordChange::removed : RecordChange::added;
    }
    record.id = id;
    out.push_back(record);
}

std::optional<TransformRecord> found(const CalibrationSet& set, const std::string& id) {
    const TransformRecord* record = set.find(id);
    return record == nullptr ? std::nullopt : std::optional(*record);
}

}  // namespace

std::string_view name_of(RecordChange change) noexcept {
    switch (change) {
        case RecordChange::same: return "same";
        case RecordChange::changed: return "changed";
        case RecordChange::added: return "added";
        case RecordChange::removed: return "removed";
    }
    return "";
}

Vec3 default_place(const CalibrationSet& set) {
    const auto& axis = reference_machine().axis;
    const auto middle = [&axis](std::size_t i) { return 0.5 * (axis.at(i).travel_min + axis.at(i).travel_max); };
    const Vec3 centre{middle(0), middle(1), middle(2)};
    return set.turntable ? Vec3{set.turntable->line.point.v.x, set.turntable->line.point.v.y + kBeforeAxis, centre.z}
                         : centre;
}

SetDiff diff_sets(const CalibrationSet& a, const CalibrationSet& b, const Vec3& at) {
    SetDiff out{.at = at, .records = {}};
    std::vector<std::string> ids;
    for (const CalibrationSet* set : {&a, &b}) {
        for (const TransformRecord& record : set->transforms) {
            if (std::ranges::find(ids, record.id) == ids.end()) {
                ids.push_back(record.id);
            }
        }
    }
    for (const std::string& id : ids) {
        compare(out.records, id, found(a, id), found(b, id), at);
    }
    compare(out.records, "turntable", a.turntable, b.turntable, at);
    compare(out.records, "axes", a.axes, b.axes, at);
    compare(out.records, "axis_map", a.axis_map, b.axis_map, at);
    compare(out.records, "galvo", a.galvo, b.galvo, at);
    compare(out.records, "galvo_field", a.galvo_field, b.galvo_field, at);
    compare(out.records, "galvo_lag", a.galvo_lag, b.galvo_lag, at);
    compare(out.records, "power", a.power, b.power, at);
    compare(out.records, "beam", a.beam, b.beam, at);
    compare(out.records, "y_sensor", a.y_sensor, b.y_sensor, at);
    compare(out.records, "triple", a.triple, b.triple, at);
    return out;
}

}  // namespace sc::host
