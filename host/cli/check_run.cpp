// SPDX-License-Identifier: Apache-2.0
#include "host/cli/check_run.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/job_items.hpp"
#include "host/formats/pulse_trace.hpp"
#include "host/formats/text.hpp"
#include "host/verification/motion_report.hpp"

namespace sc::host::cli {
namespace {

/// Numbers between separators; `count` of them.
std::vector<double> numbers_of(const std::string& option, const std::string& text, std::size_t count, char separator,
                               const std::string& form) {
    std::vector<double> numbers;
    std::size_t from = 0;
    bool good = true;
    while (good && from <= text.size()) {
        const std::size_t end = std::min(text.find(separator, from), text.size());
        double number = 0.0;
        good = parse_number(trimmed(std::string_view(text).substr(from, end - from)), number);
        numbers.push_back(number);
        from = end + 1;
    }
    if (!good || numbers.size() != count) {
        throw InputError({.problem = option + " is not of the form " + form,
                          .value = shortened(text),
                          .action = "give " + std::to_string(count) + " numbers"});
    }
    return numbers;
}

void take_limits(const std::string& option, const std::string& text, AxisLimits& axis) {
    const std::vector<double> n = numbers_of(option, text, 3, ',', "v,a,j");
    for (const double value : n) {
        if (!(value > 0.0)) {
            throw InputError({.problem = option + " holds a limit that is not above zero",
                              .value = shortened(text),
                              .action = "give speed, acceleration and jerk above zero"});
        }
    }
    axis.speed = n[0];
    axis.acceleration = n[1];
    axis.jerk = n[2];
}

KeepOut keep_out_of(const std::string& text) {
    const std::vector<double> n = numbers_of("--keep-out", text, 6, ',', "x0,y0,z0,x1,y1,z1");
    if (!(n[0] < n[3] && n[1] < n[4] && n[2] < n[5])) {
        throw InputError({.problem = "--keep-out holds no volume",
                          .value = shortened(text),
                          .action = "give the lower corner first: x0 < x1, y0 < y1, z0 < z1"});
    }
    return {{n[0], n[1], n[2]}, {n[3], n[4], n[5]}};
}

MotionLimits limits_of_machine(const MachineConfig& machine) {
    MotionLimits limits;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const AxisConfig& axis = machine.axis[i];
        limits.axis[i] = {axis.speed, axis.acceleration, axis.jerk, axis.travel_min, axis.travel_max};
    }
    limits.keep_out.assign(machine.keep_out.begin(), machine.keep_out.begin() + machine.keep_out_count);
    return limits;
}

MotionLimits limits_of(const CheckOptions& options, const MotionTrace& trace) {
    MotionLimits limits = trace.machine ? limits_of_machine(*trace.machine) : default_motion_limits();
    limits.period = trace.period;
    limits.allow = options.allow;
    limits.path_speed = options.path_speed;
    limits.may_return = options.may_return;
    if (options.vertex_tolerance_mm) {
        limits.cover = *options.vertex_tolerance_mm / options.tolerance_mm;
    }
    for (std::size_t i = 0; i < 3 && options.limits; ++i) {
        take_limits("--limits", *options.limits, limits.axis[i]);
    }
    if (options.c_limits) {
        take_limits("--c-limits", *options.c_limits, limits.axis[index(Axis::c)]);
    }
    if (options.travel) {
        const std::vector<double> n = numbers_of("--travel", *options.travel, 6, ',', "x0,x1,y0,y1,z0,z1");
        for (std::size_t i = 0; i < 3; ++i) {
            limits.axis[i].travel_min = n[2 * i];
            limits.axis[i].travel_max = n[2 * i + 1];
        }
    }
    for (const std::string& box : options.keep_out) {
        limits.keep_out.push_back(keep_out_of(box));
    }
    return limits;
}

/// The trace between two ticks, both with it.
void cut(MotionTrace& trace, const std::string& text) {
    const std::vector<double> n = numbers_of("--ticks", text, 2, ':', "FROM:TO");
    const auto first = static_cast<double>(trace.first_tick);
    const double last = first + static_cast<double>(trace.samples.size()) - 1.0;
    const bool is_whole = n[0] == std::nearbyint(n[0]) && n[1] == std::nearbyint(n[1]);
    if (!is_whole || !(n[0] >= first && n[0] < n[1] && n[1] <= last)) {
        throw InputError({.file = trace.file.string(),
                          .problem = "--ticks is no stretch of this trace",
                          .value = shortened(text),
                          .action = "give FROM < TO within " + about(first) + " to " + about(last)});
    }
    const auto from = static_cast<std::ptrdiff_t>(n[0] - first);
    const auto to = static_cast<std::ptrdiff_t>(n[1] - first) + 1;
    trace.samples = {trace.samples.begin() + from, trace.samples.begin() + to};
    trace.led = {trace.led.begin() + from, trace.led.begin() + to};
    trace.first_tick += from;
    const auto follows = std::ranges::find(trace.led, std::uint8_t{0});
    if (follows != trace.led.end()) {
        throw InputError({.file = trace.file.string(),
                          .problem = "the drives lead, not the set-points, at tick",
                          .value = std::to_string(trace.first_tick + (follows - trace.led.begin())),
                          .action = "give --ticks FROM:TO a stretch of motion: not of homing, enabling or a fault"});
    }
}

void refuse_for_cell(bool given, const char* option) {
    if (given) {
        throw InputError(
            {.problem = std::string(option) + " is for one motion, this is the trace of a whole run of a cell",
             .action = "choose the motion with --ticks FROM:TO"});
    }
}

/// Pulses and the items that asked for them.
struct PulseFiles {
    std::filesystem::path pulses;
    std::filesystem::path items;
};

std::optional<PulseFiles> pulse_files(const CheckOptions& options) {
    PulseFiles files{options.pulses.value_or(options.trace.parent_path() / "pulses.trace"), {}};
    files.items = options.items.value_or(files.pulses.parent_path() / "job.items");
    const bool asked = options.pulses || options.items;
    if (asked || (std::filesystem::exists(files.pulses) && std::filesystem::exists(files.items))) {
        return files;
    }
    return std::nullopt;
}

PulseFigures judge_pulses(const PulseFiles& files, const GateTicks& gate, const PulseLimits& limits) {
    const std::vector<Item> items = read_job_items(files.items);
    const PulseTrace trace = read_pulse_trace(files.pulses);
    try {
        PulseFigures figures = check_pulses(draw(items), trace.pulses, {.stand_each = true, .limits = limits});
        check_gate(trace.pulses, gate, figures);
        return figures;
    } catch (const std::domain_error& error) {
        throw InputError({.file = files.items.string(),
                          .problem = "does not go with these pulses",
                          .value = error.what(),
                          .action = "give the job.items and the pulses.trace of one run"});
    }
}

PulseLimits pulse_limits_of(const CheckOptions& options) {
    for (const auto& [name, percent] : {std::pair("--pitch", options.pitch_pct),
                                        {"--energy", options.energy_pct},
                                        {"--pulse-energy", options.pulse_energy_pct}}) {
        if (!(percent > 0.0 && percent <= 1000.0)) {
            throw InputError({.problem = std::string(name) + " is out of range",
                              .value = about(percent),
                              .action = "give per cent above 0, up to 1000"});
        }
    }
    return {options.pitch_pct * 1e-2, options.energy_pct * 1e-2, options.pulse_energy_pct * 1e-2};
}

MotionReport judge_cell(const CheckOptions& options, const MotionTrace& trace, const MotionLimits& limits) {
    refuse_for_cell(options.path.has_value(), "--path");
    refuse_for_cell(options.path_speed.has_value(), "--path-speed");
    MachineConfig machine = *trace.machine;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        AxisConfig& axis = machine.axis[i];
        const AxisLimits& from = limits.axis[i];
        axis.speed = from.speed;
        axis.acceleration = from.acceleration;
        axis.jerk = from.jerk;
        axis.travel_min = from.travel_min;
        axis.travel_max = from.travel_max;
    }
    if (limits.keep_out.size() > kKeepOutCapacity) {
        throw InputError({.problem = "there are too many keep-out volumes",
                          .value = std::to_string(limits.keep_out.size()),
                          .action = "a cell has at most " + std::to_string(kKeepOutCapacity)});
    }
    std::ranges::copy(limits.keep_out, machine.keep_out.begin());
    machine.keep_out_count = static_cast<std::uint8_t>(limits.keep_out.size());
    SampleChecker checker(machine, options.allow);
    GateTicks gate{.first_tick = trace.first_tick, .period_ns = machine.control_period_ns, .open = {}};
    for_each_sample(trace.file, [&](const trace::SampleRecord& record, std::span<const trace::GalvoSample> frames) {
        checker.add(record, frames);
        gate.open.push_back(record.gate != 0);
    });
    checker.end();
    MotionReport report = motion_report_of(checker.report(), machine, options.allow);
    report.pulse_limits = pulse_limits_of(options);
    if (const auto files = pulse_files(options)) {
        report.pulses = judge_pulses(*files, gate, report.pulse_limits);
    }
    report.first_tick = trace.first_tick;
    return report;
}

void check_tolerance(const char* option, double mm) {
    if (!(mm > 0.0 && mm <= 1e3)) {
        throw InputError({.problem = std::string(option) + " is out of range",
                          .value = about(mm),
                          .action = "give millimetres above 0, up to 1000"});
    }
}

template <class Value>
CLI::Option* optional_option(CLI::App& app, const char* name, std::optional<Value>& value, const char* text) {
    return app.add_option_function<std::string>(name, [&value](const std::string& word) { value = Value(word); }, text);
}

}  // namespace

void describe_check(CLI::App& app, CheckOptions& o) {
    app.add_option("trace", o.trace, "samples.trace of a cell, or a CSV of set-points (docs/formats.md)")
        ->required()
        ->type_name("TRACE");
    optional_option(app, "--limits", o.limits,
                    "of X, Y and Z each: m/s, m/s2, m/s3 (default: the trace's own; of a CSV 0.2,5,200)")
        ->type_name("v,a,j");
    optional_option(app, "--c-limits", o.c_limits,
                    "of C: deg/s, deg/s2, deg/s3 (default: the trace's own; of a CSV 45,180,1800)")
        ->type_name("v,a,j");
    app.add_option_function<double>(
           "--path-speed", [&o](double value) { o.path_speed = value; }, "limit of the speed along the path, m/s")
        ->type_name("V");
    optional_option(app, "--path", o.path, "polyline to be followed: CSV x,y,z in mm")->type_name("FILE");
    app.add_option("--tolerance", o.tolerance_mm, "how far a sample may be off the polyline, mm")
        ->type_name("MM")
        ->capture_default_str();
    app.add_option_function<double>(
           "--vertex-tolerance", [&o](double value) { o.vertex_tolerance_mm = value; },
           "how far off a vertex of the polyline may be passed, mm (default: 1.414 times the tolerance)")
        ->type_name("MM");
    app.add_flag("--may-return", o.may_return, "the motion may go back along the polyline, as after a hold");
    optional_option(app, "--travel", o.travel, "of X, Y, Z, m")->type_name("x0,x1,y0,y1,z0,z1");
    app.add_option("--keep-out", o.keep_out, "a volume not to be entered, m; may be given again")
        ->type_name("x0,y0,z0,x1,y1,z1")
        ->allow_extra_args(false);
    optional_option(app, "--ticks", o.ticks, "only these ticks, as one motion from rest to rest")->type_name("FROM:TO");
    app.add_option("--allow", o.allow, "ratio to a limit up to which speed, acceleration and jerk pass")
        ->type_name("FACTOR")
        ->capture_default_str();
    optional_option(app, "--pulses", o.pulses,
                    "pulses of the same run (default: pulses.trace beside the trace, if job.items is there too)")
        ->type_name("FILE");
    optional_option(app, "--items", o.items, "what the run was asked to burn (default: job.items beside the pulses)")
        ->type_name("FILE");
    app.add_option("--pitch", o.pitch_pct, "how far the distance of two pulses may be off, of the pitch")
        ->type_name("PCT")
        ->capture_default_str();
    app.add_option("--energy", o.energy_pct, "how far the energy of a millimetre may be off")
        ->type_name("PCT")
        ->capture_default_str();
    app.add_option("--pulse-energy", o.pulse_energy_pct,
                   "how far a pulse's energy may be off; the first ones of a laser that has rested are stronger")
        ->type_name("PCT")
        ->capture_default_str();
    app.add_flag("--json", o.json, "one JSON object on stdout, everything else on stderr");
}

CheckOutcome run_check(const CheckOptions& options) {
    if (!(options.allow >= 1.0 && options.allow <= 10.0)) {
        throw InputError({.problem = "--allow is out of range",
                          .value = about(options.allow),
                          .action = "give a factor from 1 to 10, such as 1.005"});
    }
    check_tolerance("--tolerance", options.tolerance_mm);
    check_tolerance("--vertex-tolerance", options.vertex_tolerance_mm.value_or(1.0));
    CheckOutcome outcome{.trace = read_motion_trace(options.trace), .limits = {}, .report = {}};
    outcome.limits = limits_of(options, outcome.trace);
    if (options.ticks) {
        cut(outcome.trace, *options.ticks);
    }
    outcome.limits.first_tick = outcome.trace.first_tick;
    if ((options.pulses || options.items) && (!outcome.trace.machine || options.ticks)) {
        throw InputError({.problem = "--pulses and --items are for the trace of a whole run of a cell",
                          .action = "give its samples.trace, without --ticks"});
    }
    if (outcome.trace.machine && !options.ticks) {
        outcome.report = judge_cell(options, outcome.trace, outcome.limits);
        return outcome;
    }
    const std::vector<Vec3> path = options.path ? read_polyline(*options.path) : std::vector<Vec3>{};
    outcome.report = check_motion(outcome.trace.samples, outcome.limits, path, options.tolerance_mm / 1e3);
    return outcome;
}

}  // namespace sc::host::cli
