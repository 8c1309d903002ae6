// SPDX-License-Identifier: Apache-2.0
#include <set>

#include "host/formats/calibration_units.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

constexpr Limits kResidualUm{0.0, 1e6};
constexpr Limits kSigmaUm{1e-3, 1e5};
constexpr Limits kGainPpm{-200'000.0, 200'000.0};
constexpr Limits kRangeMm{0.0, 100'000.0};
constexpr Limits kZeroMm{-100'000.0, 100'000.0};
constexpr double kLargestTilt = 0.2;  ///< of a beam; 11 degrees are no adjustment any more
constexpr std::string_view kRayOrder = "o1x,o1y,t1x,t1y,z1,g1,o2x,o2y,t2x,t2y,z2,g2,o3x,o3y,t3x,t3y,z3,g3";
constexpr std::string_view kTripleOrder =
    "o1x,o1y,t1x,t1y,z1,g1,o2x,o2y,t2x,t2y,z2,g2,o3x,o3y,t3x,t3y,z3,g3,rx,ry,rz,tx,ty,tz";

TripleRay read_triple_ray(TomlReader& table) {
    TripleRay ray;
    ray.id = table.text("id");
    const std::vector<double> origin = table.numbers("origin_mm", 2);
    ray.origin = {origin[0] / 1e3, origin[1] / 1e3};
    const std::vector<double> tilt = table.numbers("tilt_mrad", 2);
    ray.tilt = {tilt[0] / 1e3, tilt[1] / 1e3};
    for (const double t : ray.tilt) {
        if (!(t >= -kLargestTilt && t <= kLargestTilt)) {
            table.fail("tilt_mrad", "is no small tilt", decimal(t * 1e3), "adjust the beam first");
        }
    }
    ray.zero = table.number("zero_mm", kZeroMm) / 1e3;
    ray.gain = table.number("gain_ppm", kGainPpm) / 1e6;
    ray.sigma = table.number("sigma_um", kSigmaUm) / 1e6;
    table.finish();
    return ray;
}

std::size_t covered(const TripleRecord& record) {
    return record.reference ? TripleRecord::kParameters : TripleRecord::kRayParameters;
}

}  // namespace

Provenance read_provenance(TomlReader& table) {
    Provenance out;
    out.parents = table.texts("parents");
    out.residual_rms = table.number("residual_rms_um", kResidualUm) / 1e6;
    out.time = table.time("time");
    out.note = table.text_or("note", "");
    out.validity = read_validity(table, out.time);
    return out;
}

void write_provenance(TomlWriter& out, const Provenance& provenance) {
    out.texts("parents", provenance.parents);
    out.number("residual_rms_um", provenance.residual_rms, 1e6);
    out.text("time", provenance.time);
    out.text_unless_empty("note", provenance.note);
    write_validity(out, provenance.validity);
}

TripleRecord read_triple(TomlReader& table) {
    TripleRecord record;
    const std::vector<double> range = table.numbers("range_mm", 2);
    record.range = {range[0] / 1e3, range[1] / 1e3};
    if (!(range[0] >= kRangeMm.least && range[1] > range[0] && range[1] <= kRangeMm.most)) {
        table.fail("range_mm", "is no range", decimal(range[0]) + ", " + decimal(range[1]),
                   "give the least and the most reading that the sensors are good for");
    }
    std::set<std::string> seen;
    std::size_t count = 0;
    for (TomlReader& ray : table.tables("ray")) {
        if (count < record.rays.size()) {
            record.rays[count] = read_triple_ray(ray);
            if (!seen.insert(record.rays[count].id).second) {
                ray.fail("id", "appears twice", shortened(record.rays[count].id), "name each sensor once");
            }
        }
        ++count;
    }
    if (count != record.rays.size()) {
        table.fail("ray", "are not three", std::to_string(count), "give all three");
    }
    if (auto reference = table.table_if("reference")) {
        const std::vector<double> at = reference->numbers("at_mm", 2);
        record.reference = {
            reference->rotation("rotation"), reference->vector_mm("translation_mm"), {at[0] / 1e3, at[1] / 1e3}};
        static_cast<void>(reference->choice("perturbation", {"left"}));
        reference->finish();
    }
    const std::size_t size = covered(record);
    const auto rows = read_covariance_rows(table, record.reference ? kTripleOrder : kRayOrder, size);
    for (std::size_t i = 0; i < TripleRecord::kParameters; ++i) {
        for (std::size_t j = 0; j < TripleRecord::kParameters; ++j) {
            record.covariance.at[i][j] = i < size && j < size ? rows[i][j] : (i == j ? 1.0 : 0.0);
        }
    }
    record.provenance = read_provenance(table);
    table.finish();
    return record;
}

void write_triple(TomlWriter& out, const TripleRecord& record) {
    out.table("triple");
    out.numbers("range_mm", {record.range[0], record.range[1]}, 1e3);
    const std::size_t size = covered(record);
    std::vector<std::vector<double>> rows(size, std::vector<double>(size));
    for (std::size_t i = 0; i < size; ++i) {
        for (std::size_t j = 0; j < size; ++j) {
            rows[i][j] = record.covariance.at[i][j];
        }
    }
    out.text("covariance_order", record.reference ? kTripleOrder : kRayOrder);
    out.matrix("covariance", rows);
    write_provenance(out, record.provenance);
    for (const TripleRay& ray : record.rays) {
        out.item("triple.ray");
        out.text("id", ray.id);
        out.numbers("origin_mm", {ray.origin[0], ray.origin[1]}, 1e3);
        out.numbers("tilt_mrad", {ray.tilt[0], ray.tilt[1]}, 1e3);
        out.number("zero_mm", ray.zero, 1e3);
        out.number("gain_ppm", ray.gain, 1e6);
        out.number("sigma_um", ray.sigma, 1e6);
    }
    if (record.reference) {
        out.table("triple.reference");
        out.rotation("rotation", record.reference->rotation);
        out.vector("translation_mm", record.reference->translation, 1e3);
        out.numbers("at_mm", {record.reference->at[0], record.reference->at[1]}, 1e3);
        out.text("perturbation", "left");
    }
}

}  // namespace sc::host
