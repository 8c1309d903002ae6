// SPDX-License-Identifier: Apache-2.0
#include "host/formats/calibration_units.hpp"
#include "host/formats/file.hpp"

namespace sc::host {

namespace {

void write_transform(TomlWriter& out, const TransformRecord& record) {
    out.item("transform");
    out.text("id", record.id);
    out.text("unit", "mm");
    out.rotation("rotation", record.rotation);
    out.vector("translation", record.translation, 1e3);
    out.text("perturbation", "left");
    write_covariance(out, record.covariance, kRigidOrder, kRigidLengths);
    write_provenance(out, record.provenance);
}

void write_turntable(TomlWriter& out, const AxisRecord& record) {
    out.table("turntable");
    out.vector("point_mm", record.line.point.v, 1e3);
    out.vector("direction", record.line.direction.v);
    write_covariance(out, record.covariance, kAxisOrder, kAxisLengths);
    write_provenance(out, record.provenance);
}

void write_axes(TomlWriter& out, const AxesRecord& record) {
    out.table("axes");
    out.number("squareness_xy_mrad", record.squareness_xy, 1e3);
    out.number("squareness_xz_mrad", record.squareness_xz, 1e3);
    out.number("squareness_yz_mrad", record.squareness_yz, 1e3);
    out.number("scale_x_ppm", record.scale[0], 1e6);
    out.number("scale_y_ppm", record.scale[1], 1e6);
    out.number("scale_z_ppm", record.scale[2], 1e6);
    write_covariance(out, record.covariance, kAxesOrder, kAxesLengths);
    write_provenance(out, record.provenance);
}

template <std::size_t N>
void write_coefficients(TomlWriter& out, const std::string& key, const std::array<std::int32_t, N>& coefficients) {
    if (coefficients == std::array<std::int32_t, N>{}) {
        return;
    }
    std::vector<double> values;
    for (const std::int32_t c : coefficients) {
        values.push_back(static_cast<double>(c) / kMapUnits);
    }
    out.numbers(key, values);
}

void write_axis_map(TomlWriter& out, const AxisMapRecord& record) {
    const AxisMap& map = record.map;
    out.table("axis_map");
    out.numbers("first_mm", {map.first.begin(), map.first.end()}, 1e3);
    out.numbers("spacing_mm", {map.spacing.begin(), map.spacing.end()}, 1e3);
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            write_coefficients(out, map_key(i, j), map.linear[i][j]);
        }
    }
    for (std::size_t k = 0; k < kTurnTables; ++k) {
        write_coefficients(out, std::string(kTurnKeys.at(k)), map.turn[k]);
    }
    out.vector("pivot_mm", map.pivot, 1e3);
    write_coefficients(out, "backlash_um", std::array{map.backlash[0], map.backlash[1], map.backlash[2]});
    write_coefficients(out, "backlash_c_mdeg", std::array{map.backlash[3]});
    out.numbers("take_up_ms", {map.take_up.begin(), map.take_up.end()}, 1e3);
    write_provenance(out, record.provenance);
}

void write_galvo(TomlWriter& out, const GalvoRecord& record) {
    out.table("galvo");
    out.numbers("offset_um", {record.offset[0], record.offset[1]}, 1e6);
    out.matrix("matrix", {{record.matrix[0], record.matrix[1]}, {record.matrix[2], record.matrix[3]}});
    write_covariance(out, record.covariance, kGalvoOrder, kGalvoLengths);
    write_provenance(out, record.provenance);
    if (record.residual) {
        std::vector<double> x;
        std::vector<double> z;
        for (const auto& xz : record.residual->xz) {
            x.push_back(xz[0]);
            z.push_back(xz[1]);
        }
        out.table("galvo.residual");
        out.number("half_field_mm", record.residual->half_field, 1e3);
        out.integer("side", static_cast<std::int64_t>(record.residual->side));
        out.numbers("x_um", x, 1e6);
        out.numbers("z_um", z, 1e6);
    }
}

void write_galvo_field(TomlWriter& out, const GalvoFieldRecord& record) {
    const auto& v = record.value;
    out.table("galvo_field");
    out.number("angle_scale_mm", record.angle_scale, 1e3);
    out.numbers("offset_um", {v[0], v[1]}, 1e6);
    out.numbers("gain", {v[2], v[3]});
    out.number("rotation_mrad", v[4], 1e3);
    out.number("skew_mrad", v[5], 1e3);
    out.numbers("lens_mm", {v[6], v[7], v[8], v[9]}, 1e3);
    out.numbers("exit_per_m", {v[10], v[11]});
    out.number("bend_per_m2", v[12]);
    out.numbers("tilt_mrad", {v[13], v[14]}, 1e3);
    write_covariance(out, record.covariance, kGalvoFieldOrder, kGalvoFieldLengths);
    write_provenance(out, record.provenance);
    if (record.residual_side > 0) {
        std::vector<double> x;
        std::vector<double> z;
        for (const auto& xz : record.residual) {
            x.push_back(xz[0]);
            z.push_back(xz[1]);
        }
        out.table("galvo_field.residual");
        out.number("half_mm", record.residual_half, 1e3);
        out.integer("side", static_cast<std::int64_t>(record.residual_side));
        out.numbers("x_um", x, 1e6);
        out.numbers("z_um", z, 1e6);
    }
}

void write_galvo_lag(TomlWriter& out, const GalvoLagRecord& record) {
    out.table("galvo_lag");
    out.number("latency_us", static_cast<double>(record.lag.latency_ns) * 1e-3);
    out.number("natural_frequency_hz", record.lag.natural_frequency.si());
    out.number("damping", record.lag.damping);
    write_covariance(out, record.covariance, kGalvoLagOrder, kGalvoLagLengths);
    write_provenance(out, record.provenance);
}

void write_power(TomlWriter& out, const PowerRecord& record) {
    const PowerCurve& curve = record.curve;
    out.table("power");
    out.integers("bytes", {curve.byte.begin(), curve.byte.begin() + curve.count});
    out.numbers("watts", {curve.watts.begin(), curve.watts.begin() + curve.count});
    out.text("time", record.time);
    out.text_unless_empty("note", record.note);
    write_validity(out, record.validity);
}

void write_beam(TomlWriter& out, const BeamRecord& record) {
    out.table("beam");
    out.number("waist_um", record.waist, 1e6);
    out.number("rayleigh_mm", record.rayleigh_length, 1e3);
    out.text("time", record.time);
    out.text_unless_empty("note", record.note);
    write_validity(out, record.validity);
}

void write_ray(TomlWriter& out, const SensorRay& ray) {
    out.text("id", ray.id);
    out.vector("origin_mm", ray.origin.v, 1e3);
    out.vector("direction", ray.direction.v);
    out.number("zero_mm", ray.zero, 1e3);
    out.number("sigma_um", ray.sigma, 1e6);
    write_provenance(out, ray.provenance);
}

void write_records(TomlWriter& out, const CalibrationSet& set) {
    for (const TransformRecord& record : set.transforms) {
        write_transform(out, record);
    }
    if (set.turntable) {
        write_turntable(out, *set.turntable);
    }
    if (set.axes) {
        write_axes(out, *set.axes);
    }
    if (set.axis_map) {
        write_axis_map(out, *set.axis_map);
    }
    if (set.galvo) {
        write_galvo(out, *set.galvo);
    }
    if (set.galvo_field) {
        write_galvo_field(out, *set.galvo_field);
    }
    if (set.galvo_lag) {
        write_galvo_lag(out, *set.galvo_lag);
    }
    if (set.power) {
        write_power(out, *set.power);
    }
    if (set.beam) {
        write_beam(out, *set.beam);
    }
    if (set.y_sensor) {
        out.table("y_sensor");
        write_ray(out, *set.y_sensor);
    }
    for (const SensorRay& ray : set.triple_head) {
        out.item("triple_head");
        write_ray(out, ray);
    }
    if (set.triple) {
        write_triple(out, *set.triple);
    }
    write_cross_covariances(out, set);
}

/// `hash` is left out if empty.
std::string rendered(const CalibrationSet& set, std::string_view hash) {
    TomlWriter out(kCalibrationFormat);
    out.text_unless_empty("sha256", hash);
    out.text("id", set.id);
    out.texts("parents", set.parents);
    out.text("time", set.time);
    out.text_unless_empty("note", set.note);
    write_records(out, set);
    return out.str();
}

}  // namespace

std::string write_calibration(const std::filesystem::path& path, const CalibrationSet& set) {
    const std::string hash = hash_without_hash_line(rendered(set, ""));
    const std::string text = rendered(set, hash);
    static_cast<void>(parse_calibration(path, text));  // what would be refused is not written
    write_text_file(path, text);
    return hash;
}

}  // namespace sc::host
