// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "host/verification/report.hpp"

namespace sc::host {

namespace {

using Out = std::back_insert_iterator<std::string>;

/// The value without the sign that a rounded zero would keep.
double shown(double value, double half_digit) { return std::abs(value) < half_digit ? 0.0 : value; }

void add_figures(Out out, std::string_view label, const AxisFigures& figures) {
    fmt::format_to(out, "  {:<64}  max {:7.3f} {:7.3f} {:7.3f}   rms {:6.3f} {:6.3f} {:6.3f}\n", label,
                   1e3 * figures.max.x, 1e3 * figures.max.y, 1e3 * figures.max.z, 1e3 * figures.rms.x,
                   1e3 * figures.rms.y, 1e3 * figures.rms.z);
}

std::string list(const std::vector<int>& numbers) { return fmt::format("{}", fmt::join(numbers, ", ")); }

void add_gaps(Out out, const FaceAccuracy& face) {
    if (!face.not_found.empty()) {
        fmt::format_to(out, "  not found: marker {}\n", list(face.not_found));
    }
    if (!face.ambiguous.empty()) {
        fmt::format_to(out, "  ambiguous, not judged: marker {}\n", list(face.ambiguous));
    }
    for (const Point<frame::H>& place : face.unmatched) {
        fmt::format_to(out, "  a cross near no marker: x {:.3f}, z {:.3f}\n", 1e3 * place.v.x, 1e3 * place.v.z);
    }
}

void add_face(Out out, const FaceAccuracy& face) {
    fmt::format_to(out, "\n{:g}° surface (mm)\n", face.face_deg);
    fmt::format_to(out, "  {:>3}  {:^28}  {:^28}  {:^23}  {:^20}\n", "No.", "Found on the surface", "True value",
                   "Deviation", "Command error (um)");
    fmt::format_to(out, "  {:>3}  {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}   {:>7} {:>7} {:>7}  {:>6} {:>6} {:>6}\n", "",
                   "x", "y", "z", "x", "y", "z", "dx", "dy", "dz", "x", "y", "z");
    for (const PointAccuracy& p : face.points) {
        const Vec3 f = 1e3 * p.found.v;
        const Vec3 t = 1e3 * p.truth.v;
        const Vec3 d = 1e3 * p.deviation;
        fmt::format_to(out, "  {:>3}  {:9.3f} {:9.3f} {:9.3f} {:9.3f} {:9.3f} {:9.3f}   {:7.3f} {:7.3f} {:7.3f}", p.no,
                       f.x, f.y, f.z, t.x, t.y, t.z, shown(d.x, 0.0005), shown(d.y, 0.0005), shown(d.z, 0.0005));
        if (p.command_error) {
            const Vec3 e = 1e6 * *p.command_error;
            fmt::format_to(out, "  {:6.2f} {:6.2f} {:6.2f}", shown(e.x, 0.005), shown(e.y, 0.005), shown(e.z, 0.005));
        }
        fmt::format_to(out, "\n");
    }
    add_figures(out, fmt::format("found on the surface, {} points", face.points.size()), face.found);
    add_figures(out, "the table alone (measured - true)", face.csv);
    if (face.foretold && face.difference) {
        add_figures(out, "the table plus the world's known errors", *face.foretold);
        fmt::format_to(out, "  found differs from the latter by {:.2f} um at most\n", 1e6 * *face.difference);
    }
    add_gaps(out, face);
}

void add_lines(Out out, const AccuracyReport& a) {
    fmt::format_to(out, "\nDatum lines\n");
    for (const LineAccuracy& line : a.lines) {
        fmt::format_to(out,
                       "  {:>4g}°  length {:7.3f} mm, z {:8.3f} mm within {:5.2f} um, straight within {:5.2f} um; "
                       "off the markers' plane {:5.2f} um",
                       line.found.face_deg, 1e3 * line.found.length, 0.5e3 * (line.found.from.v.z + line.found.to.v.z),
                       1e6 * line.found.z_range, 1e6 * line.found.straightness, 1e6 * line.plane_distance);
        if (line.command_error) {
            fmt::format_to(out, ", its command {:5.2f} um\n", 1e6 * *line.command_error);
        } else {
            fmt::format_to(out, ", not in the plan\n");
        }
    }
    if (a.lines.empty()) {
        fmt::format_to(out, "  none found\n");
    }
    if (a.lines_missing > 0) {
        fmt::format_to(out, "  planned but not found: {}\n", a.lines_missing);
    }
}

void add_errors(Out out, const AccuracyReport& a) {
    fmt::format_to(out, "\nErrors that all crosses share (found - commanded)\n");
    for (const FoundError& error : a.common.errors) {
        fmt::format_to(out, "  {:<16} {:9.4f} ± {:.4f} {}\n", error.name, shown(error.value, 0.00005), error.sigma,
                       error.unit);
    }
    fmt::format_to(out, "  what they do not explain: rms {:.2f} um, max {:.2f} um\n", a.common.rms_um,
                   a.common.worst_um);
    if (a.known.empty()) {
        return;
    }
    fmt::format_to(out, "\nErrors that the world really has, and what calibration leaves of them\n");
    for (const ErrorBalance& line : a.known) {
        if (line.error.value == 0.0 && line.left == 0.0) {
            continue;
        }
        const std::string calibrated = line.calibrated ? fmt::format("{:.4f}", *line.calibrated) : "-";
        fmt::format_to(out, "  {:<34} {:>12.4f}  calibrated {:>12}  left {:>9.4f} {:<5}{}\n", line.error.name,
                       line.error.value, calibrated, line.left, line.error.unit,
                       line.foretold ? "" : "  (not in the expected figures)");
    }
}

void add_paths(Out out, const std::vector<PathAccuracy>& paths) {
    if (!paths.empty()) {
        fmt::format_to(out, "\nPaths\n");
    }
    for (const PathAccuracy& path : paths) {
        fmt::format_to(
            out, "  {:>5g}°  {:<24} {:>7} pulses, off the path max {:7.2f} um, rms {:6.2f} um{}\n", path.face_deg,
            path.name, path.pulses, 1e6 * path.max, 1e6 * path.rms,
            path.whole ? "" : fmt::format("; NOT WHOLE: a stretch of {:.3f} mm is dark", 1e3 * path.largest_gap));
    }
}

void add_motion(Out out, const SampleReport& samples) {
    fmt::format_to(out, "  limit violations: {} in {} ticks and {} galvo frames\n", samples.limit_violations,
                   samples.ticks, samples.galvo_frames);
    constexpr std::size_t kShown = 5;
    for (std::size_t i = 0; i < samples.first.size() && i < kShown; ++i) {
        const Violation& v = samples.first[i];
        fmt::format_to(out, "    tick {}: {} {} {:.6g}, limit {:.6g}\n", v.tick, name_of(v.breach), v.axis, v.value,
                       v.limit);
    }
}

}  // namespace

bool Report::complete() const { return accuracy.complete && std::ranges::all_of(paths, &PathAccuracy::whole); }

std::string report_text(const Report& report) {
    std::string text;
    const Out out(text);
    const AccuracyReport& a = report.accuracy;
    const BurnFindings& b = report.burns;
    fmt::format_to(out, "Job \"{}\" ({})\n", report.run.job, report.run.job_hash);
    for (const FaceAccuracy& face : a.faces) {
        add_face(out, face);
    }
    add_lines(out, a);
    add_paths(out, report.paths);
    add_errors(out, a);
    fmt::format_to(out, "\nSummary\n");
    fmt::format_to(
        out, "  burnt: {} crosses, {} lines, {} strokes in all; pulses {}, of them stray {}, off the surface {}\n",
        b.crosses.size(), b.lines.size(), b.strokes.size(), b.pulses, b.stray, b.missed);
    fmt::format_to(out, "  {}\n",
                   report.complete() ? "all that was planned was found, and nothing else"
                                     : "NOT COMPLETE: what was found is not what was planned");
    fmt::format_to(out, "  largest command error: {:.2f} um (x {:.2f}, y {:.2f}, z {:.2f})\n",
                   1e6 * a.max_command_error, 1e6 * a.max_command_error_axes.x, 1e6 * a.max_command_error_axes.y,
                   1e6 * a.max_command_error_axes.z);
    add_motion(out, report.samples);
    fmt::format_to(out, "  cell time {:.1f} s, wall time {:.1f} s, state at the end: {}\n", report.run.cell_seconds,
                   report.run.wall_seconds, report.run.state);
    fmt::format_to(out, "  command trace sha256: {}\n", report.run.command_trace_sha256);
    return text;
}

}  // namespace sc::host
