// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <nlohmann/json.hpp>

#include "host/verification/report.hpp"

namespace sc::host {

namespace {

using Json = nlohmann::ordered_json;

/// Rounded to 1 nm, so that the text of a report does not differ in digits that mean nothing.
double mm(double metres) { return std::round(metres * 1e9) * 1e-6; }
double um(double metres) { return std::round(metres * 1e9) * 1e-3; }

Json xyz_mm(const Vec3& v) { return Json::array({mm(v.x), mm(v.y), mm(v.z)}); }
Json named_mm(const Vec3& v) { return {{"x_mm", mm(v.x)}, {"y_mm", mm(v.y)}, {"z_mm", mm(v.z)}}; }

Json point_json(const PointAccuracy& p) {
    Json out{{"no", p.no},
             {"found_mm", xyz_mm(p.found.v)},
             {"true_mm", xyz_mm(p.truth.v)},
             {"measured_mm", xyz_mm(p.measured.v)},
             {"surface_y_mm", mm(p.surface_y)},
             {"deviation_mm", xyz_mm(p.deviation)},
             {"csv_deviation_mm", xyz_mm(p.csv_deviation)},
             {"sigma_um", um(p.sigma)}};
    if (p.command_error) {
        out["command_error_um"] = Json::array({um(p.command_error->x), um(p.command_error->y), um(p.command_error->z)});
    }
    if (p.foretold) {
        out["expected_deviation_mm"] = xyz_mm(*p.foretold);
    }
    return out;
}

Json face_json(const FaceAccuracy& face) {
    Json points = Json::array();
    for (const PointAccuracy& point : face.points) {
        points.push_back(point_json(point));
    }
    Json unmatched = Json::array();
    for (const Point<frame::H>& place : face.unmatched) {
        unmatched.push_back(xyz_mm(place.v));
    }
    return {{"face_deg", face.face_deg},
            {"points", face.points.size()},
            {"max", named_mm(face.found.max)},
            {"rms", named_mm(face.found.rms)},
            {"csv_max", named_mm(face.csv.max)},
            {"csv_rms", named_mm(face.csv.rms)},
            {"expected_max", face.foretold ? named_mm(face.foretold->max) : Json(nullptr)},
            {"expected_rms", face.foretold ? named_mm(face.foretold->rms) : Json(nullptr)},
            {"difference_um", face.difference ? Json(um(*face.difference)) : Json(nullptr)},
            {"not_found", face.not_found},
            {"ambiguous", face.ambiguous},
            {"unmatched_crosses_mm", std::move(unmatched)},
            {"table", std::move(points)}};
}

Json line_json(const LineAccuracy& line) {
    Json out{{"face_deg", line.found.face_deg},
             {"from_mm", xyz_mm(line.found.from.v)},
             {"to_mm", xyz_mm(line.found.to.v)},
             {"length_mm", mm(line.found.length)},
             {"straightness_um", um(line.found.straightness)},
             {"z_range_um", um(line.found.z_range)},
             {"plane_distance_um", um(line.plane_distance)}};
    out["command_error_um"] = line.command_error ? Json(um(*line.command_error)) : Json(nullptr);
    return out;
}

Json follow_json(const PathAccuracy& path) {
    return {{"path", path.path},
            {"name", path.name},
            {"face_deg", path.face_deg},
            {"pulses", path.pulses},
            {"max_um", um(path.max)},
            {"rms_um", um(path.rms)},
            {"largest_gap_um", um(path.largest_gap)},
            {"whole", path.whole}};
}

Json known_json(const std::vector<ErrorBalance>& known) {
    Json out = Json::array();
    for (const ErrorBalance& line : known) {
        Json entry{{"name", line.error.name},
                   {"value", line.error.value},
                   {"unit", line.error.unit},
                   {"compensated_by", line.error.compensated_by}};
        entry["calibrated"] = line.calibrated ? Json(*line.calibrated) : Json(nullptr);
        entry["left"] = line.left;
        entry["in_expected"] = line.foretold;
        out.push_back(std::move(entry));
    }
    return out;
}

Json found_json(const ErrorFit& fit) {
    Json out = Json::object();
    for (const FoundError& error : fit.errors) {
        const std::string key = std::string(error.name) + "_" + std::string(error.unit);
        out[key] = {{"value", error.value}, {"sigma", error.sigma}};
    }
    out["residual_rms_um"] = fit.rms_um;
    out["residual_max_um"] = fit.worst_um;
    return out;
}

Json violations_json(const SampleReport& samples) {
    Json out = Json::array();
    for (const Violation& v : samples.first) {
        out.push_back({{"rule", name_of(v.breach)},
                       {"tick", v.tick},
                       {"frame", v.frame},
                       {"axis", v.axis},
                       {"value", v.value},
                       {"limit", v.limit}});
    }
    return out;
}

Json peaks_json(const SampleReport& samples) {
    const auto peak = [](const MotionPeak& p) {
        return Json{{"speed", p.speed}, {"acceleration", p.acceleration}, {"jerk", p.jerk}};
    };
    return {{"x", peak(samples.axis_peak[0])},        {"y", peak(samples.axis_peak[1])},
            {"z", peak(samples.axis_peak[2])},        {"c", peak(samples.axis_peak[3])},
            {"galvo_x", peak(samples.galvo_peak[0])}, {"galvo_z", peak(samples.galvo_peak[1])}};
}

Json burnt_json(const BurnFindings& burns) {
    return {{"strokes", burns.strokes.size()},
            {"crosses", burns.crosses.size()},
            {"lines", burns.lines.size()},
            {"pulses", burns.pulses},
            {"missed_surface", burns.missed},
            {"off_face", burns.off_face},
            {"stray", burns.stray},
            {"strokes_alone", burns.alone.size()}};
}

}  // namespace

Json report_json(const Report& report) {
    const AccuracyReport& a = report.accuracy;
    Json faces = Json::array();
    for (const FaceAccuracy& face : a.faces) {
        faces.push_back(face_json(face));
    }
    Json lines = Json::array();
    for (const LineAccuracy& line : a.lines) {
        lines.push_back(line_json(line));
    }
    Json paths = Json::array();
    for (const PathAccuracy& path : report.paths) {
        paths.push_back(follow_json(path));
    }
    const Vec3& e = a.max_command_error_axes;
    return {{"format", "scribecell-report"},
            {"version", 1},
            {"state", report.run.state},
            {"job", report.run.job},
            {"job_hash", report.run.job_hash},
            {"complete", report.complete()},
            {"faces", std::move(faces)},
            {"max_command_error_um", um(a.max_command_error)},
            {"max_command_error_axes_um", Json::array({um(e.x), um(e.y), um(e.z)})},
            {"known_errors", known_json(a.known)},
            {"found_errors", found_json(a.common)},
            {"datum_lines", std::move(lines)},
            {"datum_lines_missing", a.lines_missing},
            {"datum_lines_extra", a.lines_extra},
            {"crosses_elsewhere", a.crosses_elsewhere},
            {"paths", std::move(paths)},
            {"burnt", burnt_json(report.burns)},
            {"pulses", report.run.pulses},
            {"limit_violations", report.samples.limit_violations},
            {"violations", violations_json(report.samples)},
            {"motion_peaks", peaks_json(report.samples)},
            {"cell_seconds", report.run.cell_seconds},
            {"wall_seconds", report.run.wall_seconds},
            {"command_trace_sha256", report.run.command_trace_sha256}};
}

}  // namespace sc::host
