// SPDX-License-Identifier: Apache-2.0
#include "host/verification/motion_report.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace sc::host {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kUm = 1e6;
constexpr std::size_t kPrintedViolations = 20;
constexpr std::array<const char*, 3> kQuantity{"speed", "acceleration", "jerk"};

std::string worst_text(const Worst& worst) {
    const std::string ratio = worst.limit > 0.0 ? fmt::format("{:.4f}", worst.ratio) : "-";
    return fmt::format(" {:>11.5g} {:>7} {:>9}", worst.value, ratio, worst.tick);
}

std::string table_text(const MotionReport& report) {
    std::string text = fmt::format("{:<8} {:<4}", "", "");
    for (std::size_t k = 0; k < 3; ++k) {
        text += fmt::format(" {:>11} {:>7} {:>9}", kQuantity[k], "ratio", "tick");
    }
    text += "\n";
    for (const MotionRow& row : report.rows) {
        text += fmt::format("{:<8} {:<4}", row.name, row.unit);
        for (const Worst& worst : row.worst) {
            text += worst_text(worst);
        }
        text += "\n";
    }
    return text;
}

std::string deviation_text(const MotionReport& report) {
    const PathDeviation& d = *report.deviation;
    std::string text = fmt::format(
        "deviation {:.4f} um of {:g} um, at tick {}; vertex {} passed {:.4f} um off, of {:.4f} "
        "um; start {:.4f} um, end {:.4f} um off\n",
        d.deviation * kUm, report.tolerance * kUm, report.first_tick + static_cast<std::int64_t>(d.sample), d.vertex,
        d.vertex_miss * kUm, report.cover_tolerance * kUm, d.start_gap * kUm, d.end_gap * kUm);
    if (!d.matched) {
        text += fmt::format("the path is lost at tick {}, after its point {}, {:.4f} um from what follows\n",
                            report.first_tick + static_cast<std::int64_t>(d.lost_sample), d.lost_vertex,
                            d.lost_distance * kUm);
    }
    return text;
}

std::string pulses_text(const PulseFigures& p, const PulseLimits& limits) {
    return fmt::format(
        "{} pulses, {} lost; pitch off by {:.2f} % rms, {:.2f} % at most, of {:g} %; energy of a pulse off by {:.2f} "
        "%, "
        "of {:g} %, of a millimetre {:.2f} %, of {:g} %\n",
        p.pulses, p.lost, p.pitch_rms * 100.0, p.pitch_peak * 100.0, limits.pitch * 100.0, p.energy_peak * 100.0,
        limits.pulse_energy * 100.0, p.energy_per_length_peak * 100.0, limits.energy * 100.0);
}

std::string violation_text(const PulseViolation& v) {
    const std::string where = fmt::format("path {} pass {} pulse {} at {:.6f} s", v.path, v.pass, v.pulse,
                                          static_cast<double>(v.t_ns) * 1e-9);
    switch (v.breach) {
        case PulseBreach::paths:
            return fmt::format("light in {:g} parts, and the job has {:g} paths to be marked", v.value, v.limit);
        case PulseBreach::count:
            return fmt::format("path {} pass {}: {:g} pulses, and it has {:g}", v.path, v.pass, v.value, v.limit);
        case PulseBreach::missed:
            return fmt::format("pulse {} at {:.6f} s met no surface", v.pulse, static_cast<double>(v.t_ns) * 1e-9);
        case PulseBreach::gate_shut:
            return fmt::format("pulse {} at {:.6f} s left while the gate was shut, tick {:.0f}", v.pulse,
                               static_cast<double>(v.t_ns) * 1e-9, v.value);
        case PulseBreach::pitch:
        case PulseBreach::energy:
        case PulseBreach::energy_per_length:
            return fmt::format("{}: {} {:.4f} of what the job asks for, limit {:g}", where, name_of(v.breach), v.value,
                               v.limit);
    }
    return {};
}

Json pulses_json(const PulseFigures& p, const PulseLimits& limits) {
    Json first = Json::array();
    for (const PulseViolation& v : p.first) {
        first.push_back({{"rule", name_of(v.breach)},
                         {"path", v.path},
                         {"pass", v.pass},
                         {"pulse", v.pulse},
                         {"t_ns", v.t_ns},
                         {"value", v.value},
                         {"limit", v.limit}});
    }
    return {{"pulses", p.pulses},
            {"lost", p.lost},
            {"pitch_rms_pct", p.pitch_rms * 100.0},
            {"pitch_peak_pct", p.pitch_peak * 100.0},
            {"pitch_limit_pct", limits.pitch * 100.0},
            {"energy_peak_pct", p.energy_peak * 100.0},
            {"pulse_energy_limit_pct", limits.pulse_energy * 100.0},
            {"energy_per_mm_peak_pct", p.energy_per_length_peak * 100.0},
            {"energy_limit_pct", limits.energy * 100.0},
            {"violations", p.violations},
            {"first", first}};
}

/// Unit of a violation's value, and by how much it is to be multiplied for a person.
struct Shown {
    const char* unit;
    double factor;
};
Shown shown(const Violation& v) {
    const bool is_c = v.axis == "c";
    switch (v.breach) {
        case Breach::speed:
        case Breach::not_at_rest: return {is_c ? "deg/s" : "m/s", 1.0};
        case Breach::acceleration: return {is_c ? "deg/s2" : "m/s2", 1.0};
        case Breach::jerk: return {is_c ? "deg/s3" : "m/s3", 1.0};
        case Breach::travel:
        case Breach::turn_not_retracted:
        case Breach::galvo_field: return {is_c ? "deg" : "m", 1.0};
        case Breach::keep_out:
        case Breach::path_end:
        case Breach::deviation:
        case Breach::vertex_skipped:
        case Breach::path_lost: return {"um", kUm};
        case Breach::missing_tick:
        case Breach::gate_outside_marking: return {"", 1.0};
    }
    return {"", 1.0};
}

MotionRow row_of(std::string_view name, const char* unit, const MotionPeak& peak, const std::array<double, 3>& limits,
                 double units, double period) {
    MotionRow row{std::string(name), unit, {}};
    const std::array<double, 3> values{peak.speed, peak.acceleration, peak.jerk};
    double scale = 1.0 / units;
    for (std::size_t k = 0; k < 3; ++k) {
        scale /= period;
        const double net = std::max(0.0, values[k] - kDifferenceRounding[k] * scale);
        row.worst[k] = {values[k], limits[k], net / limits[k], peak.tick[k]};
    }
    return row;
}

Json worst_json(const Worst& worst) {
    const bool is_limited = worst.limit > 0.0;
    return {{"value", worst.value},
            {"limit", is_limited ? Json(worst.limit) : Json()},
            {"ratio", is_limited ? Json(worst.ratio) : Json()},
            {"tick", worst.tick}};
}

Json deviation_json(const MotionReport& report) {
    const PathDeviation& d = *report.deviation;
    Json json{{"followed", d.followed},
              {"max_deviation_um", d.deviation * kUm},
              {"tolerance_um", report.tolerance * kUm},
              {"tick", report.first_tick + static_cast<std::int64_t>(d.sample)},
              {"vertex_miss_um", d.vertex_miss * kUm},
              {"vertex_tolerance_um", report.cover_tolerance * kUm},
              {"vertex", d.vertex},
              {"start_gap_um", d.start_gap * kUm},
              {"end_gap_um", d.end_gap * kUm},
              {"lost", nullptr}};
    if (!d.matched) {
        json["lost"] = {{"tick", report.first_tick + static_cast<std::int64_t>(d.lost_sample)},
                        {"after_vertex", d.lost_vertex},
                        {"distance_um", d.lost_distance * kUm}};
    }
    return json;
}

}  // namespace

MotionReport motion_report_of(const SampleReport& samples, const MachineConfig& machine, double allow) {
    constexpr std::array<std::string_view, 2> kMirrorName{"galvo x", "galvo z"};
    constexpr std::array<std::string_view, kAxisCount> kAxisName{"x", "y", "z", "c"};
    MotionReport report;
    report.ticks = samples.ticks;
    report.seconds = samples.cell_seconds;
    report.allow = allow;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const AxisConfig& axis = machine.axis[i];
        report.rows.push_back(row_of(kAxisName[i], i == index(Axis::c) ? "deg" : "m", samples.axis_peak[i],
                                     {axis.speed, axis.acceleration, axis.jerk}, units_per_base(i),
                                     1e-9 * static_cast<double>(machine.control_period_ns)));
    }
    const GalvoConfig& galvo = machine.galvo;
    for (std::size_t i = 0; i < 2; ++i) {
        report.rows.push_back(row_of(kMirrorName[i], "m", samples.galvo_peak[i],
                                     {galvo.speed.si(), galvo.acceleration.si(), galvo.jerk.si()}, kPmPerMetre,
                                     1e-9 * static_cast<double>(machine.galvo_period_ns)));
    }
    report.violations = samples.limit_violations;
    report.first = samples.first;
    return report;
}

std::string violation_text(const Violation& v) {
    const auto [unit, factor] = shown(v);
    std::string text = fmt::format("tick {}: {}", v.tick, name_of(v.breach));
    if (!v.axis.empty()) {
        text += fmt::format(" of {}", v.axis);
    }
    text += fmt::format(" {:.7g}", v.value * factor);
    text += *unit == '\0' ? "" : fmt::format(" {}", unit);
    // A keep-out volume may not be entered at all, and a lost path has no limit of its own.
    if (v.breach != Breach::keep_out && v.breach != Breach::path_lost) {
        text += fmt::format(", limit {:.7g}", v.limit * factor);
    }
    return text;
}

std::string motion_verdict(const MotionReport& report) {
    return report.passed() ? "passed: every limit is kept"
                           : fmt::format("BROKEN: {} violations",
                                         report.violations + (report.pulses ? report.pulses->violations : 0));
}

std::string motion_text(const MotionReport& report) {
    std::string text =
        fmt::format("{} ticks, {:.3f} s; ratios pass up to {:g}\n", report.ticks, report.seconds, report.allow);
    text += table_text(report);
    if (report.deviation) {
        text += deviation_text(report);
    }
    for (std::size_t i = 0; i < std::min(kPrintedViolations, report.first.size()); ++i) {
        text += "  " + violation_text(report.first[i]) + "\n";
    }
    if (report.first.size() > kPrintedViolations) {
        text += "  and elsewhere\n";
    }
    if (report.pulses) {
        text += pulses_text(*report.pulses, report.pulse_limits);
        const std::vector<PulseViolation>& first = report.pulses->first;
        for (std::size_t i = 0; i < std::min(kPrintedViolations, first.size()); ++i) {
            text += "  " + violation_text(first[i]) + "\n";
        }
        text += report.pulses->violations > kPrintedViolations ? "  and elsewhere\n" : "";
    }
    text += motion_verdict(report) + "\n";
    return text;
}

nlohmann::ordered_json motion_json(const MotionReport& report) {
    Json rows = Json::object();
    for (const MotionRow& row : report.rows) {
        Json json{{"unit", row.unit}};
        for (std::size_t k = 0; k < 3; ++k) {
            json[kQuantity[k]] = worst_json(row.worst[k]);
        }
        rows[row.name] = std::move(json);
    }
    Json first = Json::array();
    for (const Violation& v : report.first) {
        first.push_back({{"rule", name_of(v.breach)},
                         {"tick", v.tick},
                         {"frame", v.frame},
                         {"axis", v.axis},
                         {"value", v.value},
                         {"limit", v.limit}});
    }
    return {{"format", "scribecell-motion-report"},
            {"version", 1},
            {"passed", report.passed()},
            {"ticks", report.ticks},
            {"seconds", report.seconds},
            {"allow", report.allow},
            {"max_limit_ratio", report.max_limit_ratio()},
            {"axes", rows},
            {"path", report.deviation ? deviation_json(report) : Json()},
            {"pulses", report.pulses ? pulses_json(*report.pulses, report.pulse_limits) : Json()},
            {"limit_violations", report.violations},
            {"violations", first}};
}

}  // namespace sc::host
