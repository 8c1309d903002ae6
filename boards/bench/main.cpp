// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "boards/bench/motion_bench.hpp"
#include "boards/bench/polyline_file.hpp"

namespace {

using nlohmann::ordered_json;
using sc::bench::MotionFigures;
using sc::trajectory::Place;
using sc::trajectory::Problem;
using sc::trajectory::Refusal;
using sc::trajectory::Spec;

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr double kMostRatio = 1.005;
constexpr const char* kExamples = R"(Examples:
  scribecell-motion-bench --workloads tests/data/motion
      plans a_dense.csv, b_corners.csv and c_mixed.csv and prints the figures
  scribecell-motion-bench --input path.csv --limits 200,5000,200000 --tolerance 0.01
      plans one polyline (header x,y,z or x,y,z,c; mm, degrees)

Exit codes: 0 done and within the limits; 1 a limit or the tolerance is broken; 2 bad input or usage.)";

struct Arguments {
    std::string workloads;
    std::string input;
    std::vector<double> limits{200.0, 5000.0, 200000.0};
    double tolerance_mm = 0.01;
    std::string samples;
    bool json = false;
};

Spec spec_of(const Arguments& a, bool turns) {
    Spec spec;
    spec.speed = a.limits[0] * 1e-3;
    spec.tolerance = a.tolerance_mm * 1e-3;
    for (std::size_t k = 0; k < 3; ++k) {
        spec.limits.speed[k] = a.limits[0] * 1e-3;
        spec.limits.acceleration[k] = a.limits[1] * 1e-3;
        spec.limits.jerk[k] = a.limits[2] * 1e-3;
    }
    if (turns) {
        spec.limits.speed[3] = 90.0;
        spec.limits.acceleration[3] = 600.0;
        spec.limits.jerk[3] = 12000.0;
    }
    return spec;
}

std::string text_of(const Refusal& refusal) {
    const std::string point = "point " + std::to_string(refusal.point);
    const std::string axis(1, "xyzc"[refusal.axis]);
    switch (refusal.problem) {
        case Problem::bad_speed: return "--limits: the speed must be from 0.001 to 1e6 mm/s";
        case Problem::bad_tolerance: return "--tolerance: must be from 0 to 1000 mm";
        case Problem::bad_limit: return "--limits: acceleration and jerk must be more than 0";
        case Problem::bad_point: return point + ": " + axis + " is out of range; keep within 10 m";
        case Problem::blocked_axis: return point + ": " + axis + " has no limits but moves";
        case Problem::too_short: return "fewer than two points differ";
        case Problem::bad_arc:
        case Problem::no_arc_here:
        case Problem::no_room:
        case Problem::not_open: break;
    }
    return point + ": not accepted";
}

template <class T>
T value_of(const std::string& what, const std::expected<T, Refusal>& result) {
    if (!result) {
        throw sc::bench::FileError(what + ": " + text_of(result.error()));
    }
    return *result;
}

void print(const Arguments& a, const ordered_json& object) {
    std::string text;
    if (a.json) {
        text = object.dump(2) + "\n";
    } else {
        for (const auto& [name, number] : object.items()) {
            text += name + std::string(name.size() < 24 ? 24 - name.size() : 1, ' ') + number.dump() + "\n";
        }
    }
    if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) {
        throw std::runtime_error("the figures cannot be written");
    }
}

/// Samples as `scribecell check` reads them: seconds and metres, to the picometre.
void write_samples(const std::string& name, const std::vector<Place>& samples) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(name.c_str(), "w"), std::fclose);
    if (!file) {
        throw sc::bench::FileError(name + ": cannot be written: " + std::strerror(errno));
    }
    std::fputs("t_s,x_m,y_m,z_m\n", file.get());
    for (std::size_t n = 0; n < samples.size(); ++n) {
        const Place& p = samples[n];
        std::fprintf(file.get(), "%.3f,%.12f,%.12f,%.12f\n", static_cast<double>(n) * 1e-3, p[0], p[1], p[2]);
    }
    if (std::ferror(file.get()) != 0 || std::fflush(file.get()) != 0) {
        throw std::runtime_error(name + ": not written whole");
    }
}

int run_workloads(const Arguments& a) {
    const Spec spec = spec_of(a, false);
    const auto read = [&](const char* name) { return sc::bench::read_polyline(a.workloads + "/" + name); };
    const std::vector<Place> dense = read("a_dense.csv");
    const MotionFigures af = value_of("a_dense.csv", sc::bench::measure(spec, dense, 5));
    const MotionFigures bf = value_of("b_corners.csv", sc::bench::measure(spec, read("b_corners.csv"), 5));
    const MotionFigures cf = value_of("c_mixed.csv", sc::bench::measure(spec, read("c_mixed.csv"), 5));
    const double points = static_cast<double>(af.points + bf.points + cf.points);
    const double us = af.us_per_point * static_cast<double>(af.points) +
                      bf.us_per_point * static_cast<double>(bf.points) +
                      cf.us_per_point * static_cast<double>(cf.points);
    const double ratio = std::max({af.limit_ratio, bf.limit_ratio, cf.limit_ratio});
    const double deviation = std::max({af.deviation, bf.deviation, cf.deviation});
    print(a, ordered_json{{"a_dense_s", af.seconds},
                          {"b_corners_s", bf.seconds},
                          {"c_mixed_s", cf.seconds},
                          {"max_limit_ratio", ratio},
                          {"max_deviation_um", deviation * 1e6},
                          {"plan_us_per_point", us / points},
                          {"worst_insert_us", std::max({af.worst_insert_us, bf.worst_insert_us, cf.worst_insert_us})},
                          {"horizon_256_ratio", value_of("a_dense.csv", sc::bench::horizon_ratio(spec, dense))}});
    return ratio <= kMostRatio && deviation <= spec.tolerance ? 0 : kFailed;
}

int run_input(const Arguments& a) {
    const std::vector<Place> points = sc::bench::read_polyline(a.input);
    bool turns = false;
    for (const Place& p : points) {
        turns = turns || p[3] != points[0][3];
    }
    const Spec spec = spec_of(a, turns);
    const MotionFigures f = value_of(a.input, sc::bench::measure(spec, points, 3));
    if (!a.samples.empty()) {
        write_samples(a.samples, f.samples);
    }
    print(a, ordered_json{{"motion_s", f.seconds},
                          {"max_limit_ratio", f.limit_ratio},
                          {"max_deviation_um", f.deviation * 1e6},
                          {"plan_us_per_point", f.us_per_point},
                          {"worst_insert_us", f.worst_insert_us},
                          {"horizon_256_ratio", value_of(a.input, sc::bench::horizon_ratio(spec, points))},
                          {"points", f.points},
                          {"pieces", f.pieces}});
    return f.limit_ratio <= kMostRatio && f.deviation <= std::max(spec.tolerance, 1e-9) ? 0 : kFailed;
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    CLI::App app("Plans polylines with the controller's trajectory planner and measures the result.");
    app.footer(kExamples);
    auto* workloads =
        app.add_option("--workloads", arguments.workloads, "folder of the three workloads")->type_name("DIR");
    app.add_option("--input", arguments.input, "a polyline as CSV")->type_name("FILE")->excludes(workloads);
    app.add_option("--limits", arguments.limits, "path and axis speed, acceleration, jerk (mm, s)")
        ->delimiter(',')
        ->expected(3)
        ->type_name("V,A,J")
        ->capture_default_str();
    app.add_option("--tolerance", arguments.tolerance_mm, "greatest deviation, mm")
        ->type_name("T")
        ->capture_default_str();
    app.add_option("--samples", arguments.samples, "CSV of the emitted set-points at 1 kHz, for scribecell check")
        ->type_name("FILE")
        ->excludes(workloads);
    app.add_flag("--json", arguments.json, "one JSON object");
    try {
        app.parse(argc, argv);
        if (arguments.workloads.empty() && arguments.input.empty()) {
            throw CLI::RequiredError("--workloads or --input");
        }
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : kBadInput;
    }
    try {
        return arguments.input.empty() ? run_workloads(arguments) : run_input(arguments);
    } catch (const sc::bench::FileError& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return kBadInput;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-motion-bench: %s\n", error.what());
        return kFailed;
    }
}
