// SPDX-License-Identifier: Apache-2.0
#include "host/formats/calibration_set.hpp"

#include <cmath>

#include "host/formats/error.hpp"

namespace sc::host {

namespace {

InputError missing(const CalibrationSet& set, std::string_view what) {
    return InputError({.file = set.file.string(),
                       .problem = "the calibration lacks a record that this needs",
                       .value = std::string(what),
                       .action = "use a complete calibration set"});
}

Mat3 inverse_of_axes(const AxesRecord& axes) {
    // A is upper triangular, so its inverse follows by back substitution.
    const double a = 1.0 / (1.0 + axes.scale[0]);
    const double b = 1.0 / (1.0 + axes.scale[1]);
    const double c = 1.0 / (1.0 + axes.scale[2]);
    const double xy = -axes.squareness_xy * a * b;
    const double yz = -axes.squareness_yz * b * c;
    const double xz = (axes.squareness_xy * axes.squareness_yz * b - axes.squareness_xz) * a * c;
    return {{Vec3{a, xy, xz}, Vec3{0.0, b, yz}, Vec3{0.0, 0.0, c}}};
}

}  // namespace

const TransformRecord* CalibrationSet::find(std::string_view transform_id) const noexcept {
    for (const TransformRecord& record : transforms) {
        if (record.id == transform_id) {
            return &record;
        }
    }
    return nullptr;
}

Rigid<frame::H, frame::C> h_from_c(const CalibrationSet& set) {
    const TransformRecord* record = set.find("h_from_c");
    if (record == nullptr) {
        throw missing(set, "transform h_from_c");
    }
    return {record->rotation, record->translation};
}

const AxisLine& turntable_axis(const CalibrationSet& set) {
    if (!set.turntable) {
        throw missing(set, "turntable");
    }
    return set.turntable->line;
}

AxisMap axis_map_of(const CalibrationSet& set) { return set.axis_map ? set.axis_map->map : AxisMap{}; }

Compensation compensation_of(const CalibrationSet& set) {
    Compensation out;
    if (set.axes) {
        out.axis_from_h = inverse_of_axes(*set.axes);
    }
    if (set.galvo) {
        const auto& m = set.galvo->matrix;
        const double inverse_determinant = 1.0 / (m[0] * m[3] - m[1] * m[2]);
        const std::array<double, 4> g{m[3] * inverse_determinant, -m[1] * inverse_determinant,
                                      -m[2] * inverse_determinant, m[0] * inverse_determinant};
        const auto& o = set.galvo->offset;
        out.galvo_from_field = g;
        out.galvo_offset = {-(g[0] * o[0] + g[1] * o[1]), -(g[2] * o[0] + g[3] * o[1])};
    }
    return out;
}

double BeamRecord::depth_within(double tolerance) const noexcept {
    return rayleigh_length * std::sqrt(tolerance / (1.0 - tolerance));
}

GalvoLag galvo_lag_of(const CalibrationSet& set) { return set.galvo_lag ? set.galvo_lag->lag : GalvoLag{}; }

PowerCurve power_curve_of(const CalibrationSet& set) { return set.power ? set.power->curve : PowerCurve{}; }

MachineConfig machine_of(const CalibrationSet& set, MachineConfig machine) {
    if (set.power) {
        machine.laser.power = Power::from_si(set.power->curve.most());
    }
    return machine;
}

}  // namespace sc::host
