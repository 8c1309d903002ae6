// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstdio>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "host/bridge/child_process.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/asked.hpp"
#include "host/cli/bench_faults.hpp"
#include "host/cli/bench_figures.hpp"
#include "host/cli/bench_pendant.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell bench scribe
      the main job: how near the crosses are to their command, how fast the simulation is
  scribecell bench controller
      what a tick costs on a Cortex-M7, and whether board, PC and replay give the same bits (./run bench controller
      builds the image first)
  scribecell bench scribe --json --seed 7 --raw run1
      one JSON object; the trials as CSV in run1
  scribecell bench laser
      a plate of crosses, measured, fitted, and compared with the true head; then pitch, place and energy of single
      pulses at up to 2 m/s, each again with what earns it switched off; 60 tiles by stage and mirrors together
  scribecell bench motion
      the trajectory planner on three workloads: time, limits, deviation, cost
  scribecell bench motion --input path.csv --limits 200,5000,200000 --tolerance 0.01
      the same figures of any polyline (header x,y,z; mm, s)
  scribecell bench link
      points a second over each carrier with frames lost, ten million points with everything that may go wrong, and
      200 jobs whose host is killed and started again (some minutes)
  scribecell bench faults
      each fault in each state of the cell and phase of a path, judged at the plant's pins, and the firmware with a rule
      of the laser less, one by one (some minutes)
  scribecell bench sensors
      readings a second on the sensor buses, beside what the lines can carry
  scribecell bench pendant
      drive cycles from a detent of a pendant's wheel to the first set-point that moves
  scribecell bench bus
      what 3, 4 and 6 drives take of their bus: computed, and counted on it
  scribecell bench measure
      the triple-laser head: angles against the truth, calibrated and not; centres of laser spots
  scribecell bench calibration
      hand-eye, rigid transforms and turntable axes, 1000 sets each, against the truth, the least error that is possible
      and OpenCV; whole cells from scan set to beam, and centres of markers (some minutes)
  scribecell bench centres
      circular markers: centres against the truth of rendered pictures, perspective taken out
  scribecell bench stereo
      pairs of cameras: parameters and places against the truth, the bound and OpenCV
  scribecell bench allowance
      distances, fit and borrowing of a scanned casting, beside their peers (./run bench allowance builds it first)

What is asked of each figure stands in tests/bench/asked.toml.
Exit codes: 0 all figures are as asked; 1 one is not, or the benchmark failed; 2 bad input or usage.)";

constexpr std::array kBenches{
    Bench{"scribe", "the main job on the simulated cell", bench_scribe},
    Bench{"controller", "instructions a tick on a Cortex-M7, the same bits everywhere", bench_controller},
    Bench{"laser", "the galvo's field correction against the true head", bench_laser},
    Bench{"motion", "the trajectory planner on three workloads", bench_motion},
    Bench{"measure", "the triple-laser head against the true angle", bench_measure},
    Bench{"calibration", "hand-eye, transforms, axes, whole cells against truth and bound", bench_calibration},
    Bench{"centres", "centres of circular markers in rendered pictures", bench_centres},
    Bench{"stereo", "pairs of cameras against truth, bound and OpenCV", bench_stereo},
    Bench{"casting", "the main job over 20 castings, each pulse from its true datum plane", bench_casting},
    Bench{"link", "the link over every carrier, and jobs whose host dies", bench_link},
    Bench{"faults", "each fault in each state and phase, judged at the pins; rules taken out", bench_faults},
    Bench{"pendant", "a pendant's wheel, from the detent to the set-point", detent_figures},
    Bench{"sensors", "the sensor buses against what their lines can carry", bench_sensors},
    Bench{"bus", "the drive bus: computed budget beside frames counted on it", bench_bus},
    Bench{"allowance", "inspection beside Embree and CGAL", bench_allowance}};

std::string names() {
    std::string text;
    for (const Bench& bench : kBenches) {
        text += (text.empty() ? "" : ", ") + std::string(bench.name);
    }
    return text;
}

const Bench& find_bench(const std::string& name) {
    for (const Bench& bench : kBenches) {
        if (name == bench.name) {
            return bench;
        }
    }
    throw InputError({.file = {}, .problem = "no such benchmark", .value = name, .action = "choose of: " + names()});
}

/// A figure with what is asked of it.
struct Judged {
    Figure figure;
    Asked asked;
    bool met = false;
};

std::vector<Judged> judge(const Bench& bench, const std::vector<Figure>& figures) {
    const auto root = find_project_root();
    if (!root) {
        throw InputError({.file = {},
                          .problem = "tests/bench/asked.toml is not beside this program",
                          .value = {},
                          .action = "set SCRIBECELL_ROOT to the project's folder"});
    }
    const std::filesystem::path file = *root / "tests/bench/asked.toml";
    const auto asked = read_asked(file, bench.name);
    std::vector<Judged> judged;
    for (const Figure& figure : figures) {
        const auto found = asked.find(figure.name);
        if (found == asked.end()) {
            throw InputError({.file = file.string(),
                              .problem = "nothing is asked of a figure",
                              .value = std::string(bench.name) + "." + figure.name,
                              .action = "add it"});
        }
        judged.push_back({figure, found->second, meets(figure.value, found->second)});
    }
    return judged;
}

void print_text(const std::vector<Judged>& judged) {
    std::printf("%-28s %14s %-6s %14s  %s\n", "figure", "value", "unit", "asked", "met");
    for (const Judged& j : judged) {
        std::printf("%-28s %14.4f %-6s %s %12.4g  %s\n", j.figure.name.c_str(), j.figure.value, j.figure.unit.c_str(),
                    j.asked.lower_is_better ? "<" : ">", j.asked.value, j.met ? "yes" : "NO");
    }
}

void print_json(const Bench& bench, const std::vector<Judged>& judged) {
    nlohmann::ordered_json figures = nlohmann::ordered_json::array();
    for (const Judged& j : judged) {
        figures.push_back({{"name", j.figure.name},
                           {"value", j.figure.value},
                           {"unit", j.figure.unit},
                           {"asked", j.asked.value},
                           {"better", j.asked.lower_is_better ? "lower" : "higher"},
                           {"met", j.met}});
    }
    const nlohmann::ordered_json object{{"bench", bench.name}, {"figures", figures}};
    std::printf("%s\n", object.dump(2).c_str());
}

int run(const std::string& name, const BenchOptions& options, bool json) {
    const Bench& bench = find_bench(name);
    install_stop_signals();
    const std::vector<Judged> judged = judge(bench, bench.run(options));
    if (json) {
        print_json(bench, judged);
    } else {
        print_text(judged);
    }
    bool all_met = true;
    for (const Judged& j : judged) {
        all_met = all_met && j.met;
    }
    return all_met ? kDone : kFailed;
}

struct Words {
    std::string name;
    BenchOptions options;
    MotionFile motion;
    bool json = false;
};

int run_words(const Words& words) {
    const MotionFile& file = words.motion;
    if (file.input.empty()) {
        if (!file.limits.empty() || !file.tolerance.empty()) {
            throw InputError({.file = {},
                              .problem = "--limits and --tolerance are for a file",
                              .value = file.limits.empty() ? file.tolerance : file.limits,
                              .action = "give --input too"});
        }
        return run(words.name, words.options, words.json);
    }
    if (words.name != "motion") {
        throw InputError({.file = {},
                          .problem = "only the benchmark motion takes --input",
                          .value = words.name,
                          .action = "say: bench motion --input " + file.input});
    }
    return bench_motion_file(file, words.json);
}

}  // namespace

void add_bench(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("bench", "Measure, and compare with what is asked.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("name", words->name, "which: " + names())->required()->type_name("NAME");
    sub->add_flag("--json", words->json, "one JSON object");
    sub->add_option("--seed", words->options.seed, "of everything random")->type_name("N")->capture_default_str();
    sub->add_option_function<std::string>(
           "--raw", [&raw = words->options.raw](const std::string& folder) { raw = folder; },
           "folder for the trials as CSV")
        ->type_name("DIR");
    sub->add_option("--sets", words->options.sets, "calibration: sets of each kind")
        ->check(CLI::Range(10, 9999))
        ->capture_default_str();
    sub->add_option("--input", words->motion.input, "motion: a polyline as CSV")->type_name("FILE");
    sub->add_option("--limits", words->motion.limits, "motion: speed, acceleration, jerk in mm and s")
        ->type_name("V,A,J");
    sub->add_option("--tolerance", words->motion.tolerance, "motion: greatest deviation in mm")->type_name("T");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run_words(*words); }); });
}

}  // namespace sc::host::cli
