// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/stop.hpp"
#include "host/cli/all_run.hpp"
#include "host/cli/calibrate.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/formats/file.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kExamples = R"(Examples:
  scribecell calibrate all --out cell1
      the simulated cell from nothing: axes, hand-eye, h_from_c and galvo, turntable, lag; cell1/calibration.toml; then 36
      markers on four faces are measured, scribed and compared with the truth
  scribecell calibrate all --out cell2 --seed 2 --without references
      another cell, and views brought together by the robot alone: what the reference markers are worth
  scribecell calibrate all --out cell3 --without plate --pointing-um 55
      h_from_c from markers at which a person pointed

--without: axes, references, plate, axis, lag, y-sensor, triple-head; may be given several times. A call with the same options goes on where the
last one stopped. Each step keeps its data and report.json in a folder of its own.
Exit codes: 0 done; 1 the cell failed; 2 bad input, or data that cannot support a step; 130 Ctrl-C.)";

std::string text_of(const AllOutcome& outcome) {
    std::string text;
    if (!outcome.faces.empty()) {
        text += fmt::format("beam against true place, um\n{:<6} {:>8} {:>12} {:>12} {:>12}\n", "face", "markers",
                            "95 % axis", "max axis", "max 3-D");
        for (const FaceFigures& f : outcome.faces) {
            text += fmt::format("{:<6} {:>8} {:>12.1f} {:>12.1f} {:>12.1f}\n",
                                f.face_deg < 0.0 ? "all" : fmt::format("{:.0f}", f.face_deg), f.markers, f.axis_95,
                                f.axis_max, f.place_max);
        }
    }
    return text + outcome.file.string() + "\n";
}

Json json_of(const AllOutcome& outcome) {
    Json faces = Json::array();
    for (const FaceFigures& f : outcome.faces) {
        faces.push_back({{"face_deg", f.face_deg < 0.0 ? Json("all") : Json(f.face_deg)},
                         {"markers", f.markers},
                         {"axis_95_um", f.axis_95},
                         {"axis_max_um", f.axis_max},
                         {"place_max_um", f.place_max}});
    }
    return {{"format", "scribecell-calibrate-all"}, {"version", 1},           {"set", outcome.file.string()},
            {"sha256", outcome.set.sha256},         {"steps", outcome.steps}, {"faces", faces}};
}

int run(const AllOptions& asked) {
    install_stop_signals();
    AllOptions options = asked;
    options.say = [](const std::string& what) { std::fprintf(stderr, "%s\n", what.c_str()); };
    const AllOutcome outcome = run_all(options);
    const Json json = json_of(outcome);
    write_text_file(options.out / "report.json", json.dump(2) + "\n");
    std::fputs(options.json ? (json.dump(2) + "\n").c_str() : text_of(outcome).c_str(), stdout);
    return kDone;
}

}  // namespace

void add_calibrate_all(CLI::App& calibrate, int& exit_code) {
    CLI::App* sub = calibrate.add_subcommand(
        "all", "The whole simulated cell, from nothing to one calibration set, and what it is worth.");
    sub->footer(kExamples);
    const auto options = std::make_shared<AllOptions>();
    sub->add_option("--out", options->out, "folder for everything")->type_name("DIR")->required();
    sub->add_option("--seed", options->seed, "of the cell and of all noise")->type_name("N")->capture_default_str();
    sub->add_option("--without", options->without, "a step to leave out")->type_name("STEP");
    sub->add_option("--sigma-um", options->sigma_um, "noise of the 3-D sensor")
        ->check(CLI::Range(0.0, 1000.0))
        ->capture_default_str();
    sub->add_option("--pointing-um", options->pointing_um, "of a person's eye")
        ->check(CLI::Range(0.0, 1000.0))
        ->capture_default_str();
    sub->add_option("--robot-bias-mm", options->robot_bias_mm, "errors of the robot's arms; 0: it is but repeatable")
        ->check(CLI::Range(0.0, 10.0))
        ->capture_default_str();
    sub->add_option("--across", options->across, "crosses of a stand on the block along x")
        ->check(CLI::Range(2, 45))
        ->capture_default_str();
    sub->add_option("--up", options->up, "and along z")->check(CLI::Range(3, 45))->capture_default_str();
    sub->add_flag("!--no-verify", options->verify, "the set alone");
    sub->add_flag("--json", options->json, "one JSON object");
    sub->callback([options, &exit_code] { exit_code = guarded(options->json, [&] { return run(*options); }); });
}

}  // namespace sc::host::cli
