// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/stop.hpp"
#include "host/cli/calibrate.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/pointing_run.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kExamples = R"(Examples:
  scribecell calibrate pointing --out pointed
      on the simulated cell: a simulated person points at 12 markers of its mobile target; pointed/h.csv
  scribecell calibrate pointing --target mobile.toml --at-mm -240,-250,-260 --link serial:/dev/ttyUSB0 --out pointed
      a person, by keys; Ctrl-C or x ends it, and the same command goes on behind the last marker
  scribecell calibrate pointing --keys keys.txt --out pointed
      keys from a file
  scribecell calibrate pointing --target mobile.toml --link can:can0 --pendant --out pointed
      by the wheel of a USB pendant: Probe-Z takes, Safe-Z skips, Reset ends
  scribecell calibrate rigid --from c.csv --to pointed/h.csv --name h_from_c
      what the places are for

Keys: a d x, w s z, e q y; 1 2 3 4 steps of 1, 0.1, 0.01, 0.002 mm; t take, n skip, x end. The first marker is brought into
focus several times; from then on y stays, and depths are y1 + a1 - a2 by the distance sensor, with the certified heights of
the target's steps. Without a sensor each marker is brought into focus. The guide laser is on where key and enclosure
allow it.

Exit codes: 0 done; 1 the cell failed; 2 bad input, or too few markers; 130 Ctrl-C.)";

int run(const PointingOptions& options) {
    install_stop_signals();
    const PointingOutcome outcome = run_pointing(options);
    Json json{{"format", "scribecell-pointing"},     {"version", 1},
              {"markers", outcome.markers.size()},   {"stopped", outcome.stopped},
              {"focus_y_mm", outcome.focus_y * 1e3}, {"focus_sigma_um", outcome.focus_sigma * 1e6},
              {"h", outcome.h_csv.string()}};
    std::string text = fmt::format(
        "{} markers{}; focus of the first at y = {:.4f} mm, 1 sigma {:.1f} um (common to all)\n",
        outcome.markers.size(), outcome.stopped ? ", not all" : "", outcome.focus_y * 1e3, outcome.focus_sigma * 1e6);
    if (outcome.depths) {
        const StepDepths& d = *outcome.depths;
        json["sensor_gain_ppm"] = d.gain * 1e6;
        json["sensor_gain_sigma_ppm"] = d.gain_sigma * 1e6;
        json["tilt_mrad"] = {d.tilt_x * 1e3, d.tilt_z * 1e3};
        json["depth_rms_um"] = d.rms * 1e6;
        text += fmt::format(
            "depths by sensor and steps: {:.2f} um rms; sensor's gain {:.0f} +- {:.0f} ppm; target leans {:.3f}, "
            "{:.3f} "
            "mrad\n",
            d.rms * 1e6, d.gain * 1e6, d.gain_sigma * 1e6, d.tilt_x * 1e3, d.tilt_z * 1e3);
    } else {
        text += "depths by eye: the distance sensor gave nothing\n";
    }
    text += outcome.h_csv.string() + "\n";
    std::fputs(options.json ? (json.dump(2) + "\n").c_str() : text.c_str(), stdout);
    return kDone;
}

}  // namespace

void add_calibrate_pointing(CLI::App& calibrate, int& exit_code) {
    CLI::App* sub = calibrate.add_subcommand(
        "pointing", "Markers of the mobile target in h, by pointing the guide spot at one after another.");
    sub->footer(kExamples);
    const auto options = std::make_shared<PointingOptions>();
    sub->add_option("--out", options->out, "folder for pointing.csv and h.csv")->type_name("DIR")->required();
    sub->add_option("--target", options->target, "the mobile target")->type_name("FILE");
    add_pendant_options(*sub, options->pendant);
    sub->add_option("--calibration", options->calibration, "set whose [axes] hold")->type_name("FILE");
    sub->add_option("--at-mm", options->at_mm, "roughly where the target's zero stands in h")
        ->delimiter(',')
        ->expected(3)
        ->capture_default_str();
    sub->add_option("--keys", options->keys, "keys in place of a terminal's")->type_name("FILE");
    sub->add_option("--link", options->link,
                    "the cell: sim:, can:IFACE[?fd=1], serial:/dev/...[?baud=N], tcp:HOST:PORT")
        ->type_name("URL")
        ->capture_default_str();
    add_key_option(*sub, options->key);
    sub->add_option("--world", options->base_world, "of the simulated cell; the target is put into it")
        ->type_name("FILE");
    sub->add_option("--markers", options->markers, "how many; 0: all")
        ->check(CLI::Range(0, 500))
        ->capture_default_str();
    sub->add_option("--looks", options->looks, "at the focus of the first")
        ->check(CLI::Range(1, 99))
        ->capture_default_str();
    sub->add_option("--pointing-um", options->pointing_um, "how well the spot is brought onto a cross, 1 sigma")
        ->check(CLI::Range(0.0, 1000.0))
        ->capture_default_str();
    sub->add_option("--focusing-um", options->focusing_um, "and into focus")
        ->check(CLI::Range(0.0, 5000.0))
        ->capture_default_str();
    sub->add_option("--seed", options->seed, "of everything random")->type_name("N")->capture_default_str();
    sub->add_flag("--json", options->json, "one JSON object");
    sub->callback([options, &exit_code] { exit_code = guarded(options->json, [&] { return run(*options); }); });
}

}  // namespace sc::host::cli
