// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <set>

#include "host/formats/calibration_store.hpp"
#include "host/formats/calibration_units.hpp"
#include "host/formats/file.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

constexpr std::array kUnits{kMillimetre, kMetre, kInch};
constexpr Limits kSigmaUm{1e-6, 1e6};
constexpr Limits kWaistUm{1.0, 1000.0};
constexpr Limits kRayleighMm{0.001, 1e6};
constexpr Limits kSquarenessMrad{-50.0, 50.0};
constexpr Limits kScalePpm{-50'000.0, 50'000.0};

TransformRecord read_transform(TomlReader& table) {
    TransformRecord out;
    out.id = table.text("id");
    const LengthUnit unit = kUnits[table.choice("unit", {"mm", "m", "inch"})];
    out.rotation = table.rotation("rotation");
    const Vec3 t = table.vector("translation");
    out.translation = {unit.to_si(t.x, 1), unit.to_si(t.y, 1), unit.to_si(t.z, 1)};
    static_cast<void>(table.choice("perturbation", {"left"}));
    out.covariance = read_covariance(table, kRigidOrder, kRigidLengths, unit);
    out.provenance = read_provenance(table);
    table.finish();
    return out;
}

AxisRecord read_turntable(TomlReader& table) {
    AxisRecord out;
    out.line.point.v = table.vector_mm("point_mm");
    out.line.direction.v = table.unit_vector("direction");
    if (!(out.line.direction.v.z > 0.5)) {
        table.fail("direction", "does not point up, its z is", decimal(out.line.direction.v.z),
                   "give the direction whose z is near +1: C counts counter-clockwise seen from +z");
    }
    out.covariance = read_covariance(table, kAxisOrder, kAxisLengths, kMillimetre);
    out.provenance = read_provenance(table);
    table.finish();
    return out;
}

AxesRecord read_axes(TomlReader& table) {
    AxesRecord out;
    out.squareness_xy = table.number("squareness_xy_mrad", kSquarenessMrad) / 1e3;
    out.squareness_xz = table.number("squareness_xz_mrad", kSquarenessMrad) / 1e3;
    out.squareness_yz = table.number("squareness_yz_mrad", kSquarenessMrad) / 1e3;
    out.scale = {table.number("scale_x_ppm", kScalePpm) / 1e6, table.number("scale_y_ppm", kScalePpm) / 1e6,
                 table.number("scale_z_ppm", kScalePpm) / 1e6};
    out.covariance = read_covariance(table, kAxesOrder, kAxesLengths, kMillimetre);
    out.provenance = read_provenance(table);
    table.finish();
    return out;
}

template <std::size_t N>
void read_coefficients(TomlReader& table, const std::string& key, std::array<std::int32_t, N>& out) {
    if (!table.has(key)) {
        return;
    }
    const auto values = table.numbers(key, N);
    for (std::size_t k = 0; k < N; ++k) {
        if (!(std::abs(values[k]) <= kLargestCoefficient)) {
            table.fail(key, "has a coefficient that no map can hold", decimal(values[k]), "calibrate again");
        }
        out[k] = static_cast<std::int32_t>(std::llround(values[k] * kMapUnits));
    }
}

AxisMapRecord read_axis_map(TomlReader& table) {
    AxisMapRecord out;
    const auto first = table.numbers("first_mm", 3);
    const auto spacing = table.numbers("spacing_mm", 3);
    for (std::size_t i = 0; i < 3; ++i) {
        out.map.first[i] = first[i] / 1e3;
        out.map.spacing[i] = spacing[i] / 1e3;
        for (std::size_t j = 0; j < 3; ++j) {
            read_coefficients(table, map_key(i, j), out.map.linear[i][j]);
        }
    }
    for (std::size_t k = 0; k < kTurnTables; ++k) {
        read_coefficients(table, std::string(kTurnKeys.at(k)), out.map.turn[k]);
    }
    out.map.pivot = table.vector_mm("pivot_mm");
    std::array<std::int32_t, 3> linear{};
    std::array<std::int32_t, 1> turn{};
    read_coefficients(table, "backlash_um", linear);
    read_coefficients(table, "backlash_c_mdeg", turn);
    out.map.backlash = {linear[0], linear[1], linear[2], turn[0]};
    const auto take_up = table.numbers("take_up_ms", kAxisCount);
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        out.map.take_up[i] = take_up[i] / 1e3;
    }
    out.provenance = read_provenance(table);
    table.finish();
    return out;
}

GalvoResidual read_residual(TomlReader& table) {
    GalvoResidual out;
    out.half_field = table.number("half_field_mm", {0.001, 1000.0}) / 1e3;
    out.side = static_cast<std::size_t>(table.integer("side", 2, 257));
    const auto x = table.numbers("x_um", out.side * out.side);
    const auto z = table.numbers("z_um", out.side * out.side);
    for (std::size_t i = 0; i < x.size(); ++i) {
        out.xz.push_back({x[i] / 1e6, z[i] / 1e6});
    }
    table.finish();
    return out;
}

GalvoRecord read_galvo(TomlReader& table) {
    GalvoRecord out;
    const auto offset = table.numbers("offset_um", 2);
    out.offset = {offset[0] / 1e6, offset[1] / 1e6};
    const auto m = table.matrix("matrix", 2, 2);
    out.matrix = {m[0][0], m[0][1], m[1][0], m[1][1]};
    if (const double determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0]; !(determinant > 0.25 && determinant < 4.0)) {
        table.fail("matrix", "is far from the head's nominal scale or mirrored, determinant", about(determinant),
                   "give the 2x2 matrix near the identity; correct mirrored mirrors in the machine's configuration");
    }
    out.covariance = read_covariance(table, kGalvoOrder, kGalvoLengths, kMillimetre);
    if (auto residual = table.table_if("residual")) {
        out.residual = read_residual(*residual);
    }
    out.provenance = read_provenance(table);
    table.finish();
    return out;
}

GalvoFieldRecord read_galvo_field(TomlReader& table) {
    GalvoFieldRecord out;
    out.angle_scale = table.number("angle_scale_mm", {1.0, 10'000.0}) / 1e3;
    const auto offset = table.numbers("offset_um", 2);
    const auto gain = table.numbers("gain", 2);
    const auto lens = table.numbers("lens_mm", 4);
    const auto exit = table.numbers("exit_per_m", 2);
    const auto tilt = table.numbers("tilt_mrad", 2);
    out.value = {offset[0] / 1e6,
                 offset[1] / 1e6,
                 gain[0],
                 gain[1],
                 table.number("rotation_mrad", {-200.0, 200.0}) / 1e3,
                 table.number("skew_mrad", {-200.0, 200.0}) / 1e3,
                 lens[0] / 1e3,
                 lens[1] / 1e3,
                 lens[2] / 1e3,
                 lens[3] / 1e3,
                 exit[0],
                 exit[1],
                 table.number("bend_per_m2", {-500.0, 500.0}),
                 tilt[0] / 1e3,
                 tilt[1] / 1e3};
    for (const std::size_t i : {0U, 1U}) {
        if (!(gain[i] > 0.5 && gain[i] < 1.5)) {
            table.fail("gain", "is far from 1", decimal(gain[i]),
                       "correct mirrored or rescaled mirrors in the machine's configuration");
        }
    }
    if (!(lens[0] > 0.5 * 1e3 * out.angle_scale && lens[0] < 2e3 * out.angle_scale)) {
        table.fail("lens_mm", "does not fit angle_scale_mm: its first is", decimal(lens[0]),
                   "give the image height per radian of optical angle first");
    }
    out.covariance = read_covariance(table, kGalvoFieldOrder, kGalvoFieldLengths, kMetre);
    if (auto residual = table.table_if("residual")) {
        out.residual_half = residual->number("half_mm", {1.0, 1000.0}) / 1e3;
        out.residual_side = static_cast<std::size_t>(residual->integer("side", 4, 65));
        const auto x = residual->numbers("x_um", out.residual_side * out.residual_side);
        const auto z = residual->numbers("z_um", out.residual_side * out.residual_side);
        for (std::size_t i = 0; i < x.size(); ++i) {
            out.residual.push_back({x[i] / 1e6, z[i] / 1e6});
        }
        residual->finish();
    }
    out.provenance = read_provenance(table);
    table.finish();
    return out;
}

GalvoLagRecord read_galvo_lag(TomlReader& table) {
    GalvoLagRecord out;
    out.lag = {std::llround(table.number("latency_us", {1.0, 1000.0}) * 1e3),
               Frequency::from_si(table.number("natural_frequency_hz", {200.0, 20e3})),
               table.number("damping", {0.1, 10.0})};
    if (galvo_lead(with_lag({}, out.lag), 0).per_velocity > static_cast<double>(out.lag.latency_ns) * 1e-9) {
        table.fail("latency_us", "is below the servo's own lag, 2 damping / (2 pi natural_frequency_hz)",
                   decimal(static_cast<double>(out.lag.latency_ns) * 1e-3), "tune it again");
    }
    out.covariance = read_covariance(table, kGalvoLagOrder, kGalvoLagLengths, kMetre);
    out.provenance = read_provenance(table);
    table.finish();
    return out;
}

SensorRay read_ray(TomlReader& table) {
    SensorRay out;
    out.id = table.text("id");
    out.origin.v = table.vector_mm("origin_mm");
    out.direction.v = table.unit_vector("direction");
    out.zero = table.number("zero_mm") / 1e3;
    out.sigma = table.number("sigma_um", kSigmaUm) / 1e6;
    out.provenance = read_provenance(table);
    table.finish();
    return out;
}

PowerRecord read_power(TomlReader& table) {
    PowerRecord out;
    const std::vector<std::int64_t> bytes = table.integers("bytes");
    const std::vector<double> watts = table.any_numbers("watts");
    if (bytes.size() < 2 || bytes.size() > PowerCurve::kPoints) {
        table.fail("bytes", "holds fewer than 2 or more than 17 points", std::to_string(bytes.size()),
                   "give 2 to 17 power bytes, the last of them 255");
    }
    if (watts.size() != bytes.size()) {
        table.fail("watts", "is not as long as bytes", std::to_string(watts.size()), "give one power for each byte");
    }
    out.curve.count = static_cast<std::uint8_t>(bytes.size());
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        if (bytes[i] < 0 || bytes[i] > 255) {
            table.fail("bytes", "has a value outside 0..255", std::to_string(bytes[i]), "give power bytes");
        }
        out.curve.byte[i] = static_cast<std::uint8_t>(bytes[i]);
        out.curve.watts[i] = watts[i];
    }
    if (const std::size_t bad = sound_points(out.curve); !sound(out.curve)) {
        const bool of_bytes =
            (bad > 0 && bytes[bad] <= bytes[bad - 1]) || (bad + 1 == bytes.size() && bytes[bad] != 255);
        table.fail(of_bytes ? "bytes" : "watts", "does not rise up to byte 255, at point",
                   std::to_string(bad + 1) + " (" + std::to_string(bytes[bad]) + ": " + decimal(watts[bad]) + " W)",
                   "measure from low to high, the last point at byte 255; leave a point out that repeats another");
    }
    out.time = table.time("time");
    out.note = table.text_or("note", "");
    out.validity = read_validity(table, out.time);
    table.finish();
    return out;
}

BeamRecord read_beam(TomlReader& table) {
    BeamRecord out;
    out.waist = table.number("waist_um", kWaistUm) / 1e6;
    out.rayleigh_length = table.number("rayleigh_mm", kRayleighMm) / 1e3;
    out.time = table.time("time");
    out.note = table.text_or("note", "");
    out.validity = read_validity(table, out.time);
    table.finish();
    return out;
}

void read_transforms(TomlReader& root, CalibrationSet& set) {
    std::set<std::string> seen;
    for (TomlReader& table : root.tables("transform")) {
        set.transforms.push_back(read_transform(table));
        const std::string& id = set.transforms.back().id;
        if (!seen.insert(id).second) {
            table.fail("id", "appears twice", shortened(id), "keep one of them");
        }
    }
}

void read_sensors(TomlReader& root, CalibrationSet& set) {
    if (auto table = root.table_if("y_sensor")) {
        set.y_sensor = read_ray(*table);
    }
    for (TomlReader& table : root.tables("triple_head")) {
        set.triple_head.push_back(read_ray(table));
    }
    if (!set.triple_head.empty() && set.triple_head.size() != 3) {
        root.fail("triple_head", "has not three rays", std::to_string(set.triple_head.size()), "give all three");
    }
    if (auto table = root.table_if("triple")) {
        set.triple = read_triple(*table);
    }
}

void check_hash(const TomlReader& root, const CalibrationSet& set, const std::string& stated) {
    if (!stated.empty() && stated != set.sha256) {
        root.fail("sha256", "does not belong to this content", shortened(stated),
                  "the file was changed by hand or damaged: restore it, or remove the line to accept the change");
    }
}

}  // namespace

CalibrationSet parse_calibration(const std::filesystem::path& path, std::string_view text) {
    TomlDocument document(path, text, kCalibrationFormat);
    TomlReader& root = document.root();
    CalibrationSet set;
    set.file = path;
    set.sha256 = hash_without_hash_line(text);
    check_hash(root, set, root.text_or("sha256", ""));
    set.id = root.text("id");
    set.parents = root.texts("parents");
    set.time = root.time("time");
    set.note = root.text_or("note", "");
    read_transforms(root, set);
    if (auto table = root.table_if("turntable")) {
        set.turntable = read_turntable(*table);
    }
    if (auto table = root.table_if("axes")) {
        set.axes = read_axes(*table);
    }
    if (auto table = root.table_if("axis_map")) {
        set.axis_map = read_axis_map(*table);
    }
    if (auto table = root.table_if("galvo")) {
        set.galvo = read_galvo(*table);
    }
    if (auto table = root.table_if("galvo_field")) {
        set.galvo_field = read_galvo_field(*table);
    }
    if (auto table = root.table_if("galvo_lag")) {
        set.galvo_lag = read_galvo_lag(*table);
    }
    if (auto table = root.table_if("power")) {
        set.power = read_power(*table);
    }
    if (auto table = root.table_if("beam")) {
        set.beam = read_beam(*table);
    }
    read_sensors(root, set);
    read_cross_covariances(root, set);
    check_joint_covariance(root, set);
    root.finish();
    return set;
}

CalibrationSet read_calibration(const std::filesystem::path& path) {
    const std::filesystem::path file = names_stored_set(path) ? stored_set_file(path) : path;
    return parse_calibration(file, read_text_file(file));
}

}  // namespace sc::host
