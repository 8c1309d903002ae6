// SPDX-License-Identifier: Apache-2.0
#include "host/verification/world_errors.hpp"

#include <cmath>
#include <functional>
#include <string_view>

namespace sc::host {

namespace {

/// The galvo's linear model as its makers and the world's file name it: M = [k_x cos ρ, −k_z sin(ρ + σ); k_x sin ρ,
/// k_z cos(ρ + σ)].
struct GalvoShape {
    double gain_x = 1.0;
    double gain_z = 1.0;
    double rotation = 0.0;
    double skew = 0.0;
};

std::array<double, 4> matrix_of(const GalvoShape& g) {
    const double z_way = g.rotation + g.skew;
    return {g.gain_x * std::cos(g.rotation), -g.gain_z * std::sin(z_way), g.gain_x * std::sin(g.rotation),
            g.gain_z * std::cos(z_way)};
}

GalvoShape shape_of(const std::array<double, 4>& m) {
    const double rotation = std::atan2(m[2], m[0]);
    return {std::hypot(m[0], m[2]), std::hypot(m[1], m[3]), rotation, std::atan2(-m[1], m[3]) - rotation};
}

/// An error by name: where the calibration holds it. Values in SI.
struct Entry {
    std::string_view name;
    std::function<std::optional<double>(const CalibrationSet&)> calibrated;
};

std::optional<double> of_axes(const CalibrationSet& set, const std::function<double(const AxesRecord&)>& value) {
    return set.axes ? std::optional(value(*set.axes)) : std::nullopt;
}
std::optional<double> of_galvo(const CalibrationSet& set, const std::function<double(const GalvoRecord&)>& value) {
    return set.galvo ? std::optional(value(*set.galvo)) : std::nullopt;
}
std::optional<double> of_shape(const CalibrationSet& set, double GalvoShape::* member) {
    return of_galvo(set, [member](const GalvoRecord& g) { return shape_of(g.matrix).*member; });
}

const std::vector<Entry>& entries() {
    using Set = CalibrationSet;
    static const std::vector<Entry> kEntries{
        {"axes.squareness_xy", [](const Set& s) { return of_axes(s, [](auto& a) { return a.squareness_xy; }); }},
        {"axes.squareness_xz", [](const Set& s) { return of_axes(s, [](auto& a) { return a.squareness_xz; }); }},
        {"axes.squareness_yz", [](const Set& s) { return of_axes(s, [](auto& a) { return a.squareness_yz; }); }},
        {"axes.scale_x", [](const Set& s) { return of_axes(s, [](auto& a) { return a.scale[0]; }); }},
        {"axes.scale_y", [](const Set& s) { return of_axes(s, [](auto& a) { return a.scale[1]; }); }},
        {"axes.scale_z", [](const Set& s) { return of_axes(s, [](auto& a) { return a.scale[2]; }); }},
        {"galvo.offset_x", [](const Set& s) { return of_galvo(s, [](auto& g) { return g.offset[0]; }); }},
        {"galvo.offset_z", [](const Set& s) { return of_galvo(s, [](auto& g) { return g.offset[1]; }); }},
        {"galvo.gain_x", [](const Set& s) { return of_shape(s, &GalvoShape::gain_x); }},
        {"galvo.gain_z", [](const Set& s) { return of_shape(s, &GalvoShape::gain_z); }},
        {"galvo.rotation", [](const Set& s) { return of_shape(s, &GalvoShape::rotation); }},
        {"galvo.skew", [](const Set& s) { return of_shape(s, &GalvoShape::skew); }},
    };
    return kEntries;
}

const Entry* find_entry(std::string_view name) {
    for (const Entry& entry : entries()) {
        if (entry.name == name) {
            return &entry;
        }
    }
    return nullptr;
}

double si_of(std::string_view unit) {
    if (unit == "mrad" || unit == "mm") {
        return 1e-3;
    }
    if (unit == "um" || unit == "urad" || unit == "ppm") {
        return 1e-6;
    }
    return 1.0;
}

double value_of(std::span<const KnownError> errors, std::string_view name, double absent) {
    for (const KnownError& error : errors) {
        if (error.name == name) {
            return error.value * si_of(error.unit);
        }
    }
    return absent;
}

/// The calibration's axis of the turntable, as the header would name it; SI.
std::optional<double> of_turntable(const CalibrationSet& set, std::string_view name, double height) {
    if (!set.turntable) {
        return std::nullopt;
    }
    const AxisLine& line = set.turntable->line;
    const Vec3& u = line.direction.v;
    // The point of the line at the height at which the header gives it.
    const Vec3 foot = line.point.v + ((height - line.point.v.z) / u.z) * u;
    if (name == "turntable.axis_x") {
        return foot.x;
    }
    if (name == "turntable.axis_y") {
        return foot.y;
    }
    if (name == "turntable.direction_x") {
        return u.x / u.z;
    }
    if (name == "turntable.direction_y") {
        return u.y / u.z;
    }
    return std::nullopt;
}

}  // namespace

std::vector<ErrorBalance> balance(std::span<const KnownError> errors, const CalibrationSet& set) {
    const double height = value_of(errors, "turntable.axis_z", 0.0);
    std::vector<ErrorBalance> list;
    for (const KnownError& error : errors) {
        const Entry* const entry = find_entry(error.name);
        const std::optional<double> si =
            entry != nullptr ? entry->calibrated(set) : of_turntable(set, error.name, height);
        ErrorBalance line{error, std::nullopt, error.value, entry != nullptr};
        if (si) {
            line.calibrated = *si / si_of(error.unit);
            line.left = error.value - *line.calibrated;
        } else if (entry != nullptr && (entry->name == "galvo.gain_x" || entry->name == "galvo.gain_z")) {
            line.left = error.value - 1.0;
        }
        list.push_back(std::move(line));
    }
    return list;
}

MachineTruth machine_truth(std::span<const KnownError> errors) {
    const auto value = [errors](std::string_view name, double absent = 0.0) { return value_of(errors, name, absent); };
    MachineTruth truth;
    truth.squareness = {value("axes.squareness_xy"), value("axes.squareness_xz"), value("axes.squareness_yz")};
    truth.scale = {value("axes.scale_x"), value("axes.scale_y"), value("axes.scale_z")};
    truth.galvo_offset = {value("galvo.offset_x"), value("galvo.offset_z")};
    truth.galvo_matrix = matrix_of(
        {value("galvo.gain_x", 1.0), value("galvo.gain_z", 1.0), value("galvo.rotation"), value("galvo.skew")});
    return truth;
}

Vec3 foretell(const MachineTruth& truth, const Compensation& compensation, const Vec3& place, Actuator actuator,
              const Vec3& anchor) {
    const Vec3 stand = actuator == Actuator::galvo ? anchor : place;
    const Vec3 field = place - stand;
    const Vec3 q = compensation.axis_from_h * stand + compensation.axis_offset;
    const auto& [xy, xz, yz] = truth.squareness;
    const Vec3 focus{q.x * (1.0 + truth.scale[0]) + xy * q.y + xz * q.z, q.y * (1.0 + truth.scale[1]) + yz * q.z,
                     q.z * (1.0 + truth.scale[2])};
    const auto& inverse = compensation.galvo_from_field;
    const double gx = inverse[0] * field.x + inverse[1] * field.z + compensation.galvo_offset[0];
    const double gz = inverse[2] * field.x + inverse[3] * field.z + compensation.galvo_offset[1];
    const auto& m = truth.galvo_matrix;
    return {focus.x + truth.galvo_offset[0] + m[0] * gx + m[1] * gz, focus.y,
            focus.z + truth.galvo_offset[1] + m[2] * gx + m[3] * gz};
}

}  // namespace sc::host
