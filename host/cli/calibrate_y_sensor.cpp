// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/stop.hpp"
#include "host/cli/calibrate.hpp"
#include "host/cli/calibrate_places.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/y_sensor_run.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kExamples = R"(Examples:
  scribecell calibrate y-sensor --cell cell1 --out y1
      scans a roof of five faces in the simulated cell that `calibrate all --out cell1` has calibrated (same seed)
  scribecell calibrate y-sensor --calibration cell.toml --points roof_c.csv --roughly roof_h.csv --out y1
      --link serial:/dev/ttyUSB0
      a real roof: its faces as the 3-D sensor measured them (facet,x_mm,y_mm,z_mm,sigma_um; c), and a place on each in h
  scribecell calibrate y-sensor --calibration cell.toml --points roof_c.csv --readings y1/readings.csv --out y2
      readings (facet,x_mm,y_mm,z_mm,reading_mm,sigma_mm) of a scan that was made before

Faces must lean in x and in z, and be scanned at several distances: else the blind direction is named.
Exit codes: 0 done; 1 the cell failed; 2 bad input, or readings that cannot support a fit; 130 Ctrl-C.)";

int run(const YSensorOptions& options) {
    install_stop_signals();
    const YSensorOutcome outcome = run_y_sensor(options);
    const SensorRayFit& fit = outcome.fit;
    const auto sigma = [&fit](std::size_t i) { return std::sqrt(fit.covariance.at[i][i]); };
    if (options.json) {
        const Json json{{"format", "scribecell-y-sensor"},
                        {"version", 1},
                        {"origin_mm", vector_json(1e3 * fit.origin)},
                        {"direction", vector_json(fit.direction)},
                        {"zero_mm", fit.zero * 1e3},
                        {"sigma",
                         {{"origin_x_um", sigma(0) * 1e6},
                          {"origin_z_um", sigma(1) * 1e6},
                          {"direction_x_mrad", sigma(2) * 1e3},
                          {"direction_z_mrad", sigma(3) * 1e3},
                          {"zero_um", sigma(4) * 1e6}}},
                        {"covariance", fit.covariance.at},
                        {"rms_um", fit.rms * 1e6},
                        {"readings", fit.readings},
                        {"wrong_lines", fit.wrong},
                        {"file", outcome.files}};
        std::printf("%s\n", json.dump(2).c_str());
        return kDone;
    }
    std::string text = fmt::format(
        "origin    x {:.4f} +- {:.4f} mm, z {:.4f} +- {:.4f} mm\n"
        "direction x {:.3f} +- {:.3f} mrad, z {:.3f} +- {:.3f} mrad\nzero      {:.4f} +- {:.4f} mm\n"
        "{} readings, {:.1f} um rms along the beam\n",
        fit.origin.x * 1e3, sigma(0) * 1e3, fit.origin.z * 1e3, sigma(1) * 1e3, fit.direction.x * 1e3, sigma(2) * 1e3,
        fit.direction.z * 1e3, sigma(3) * 1e3, fit.zero * 1e3, sigma(4) * 1e3, fit.readings, fit.rms * 1e6);
    for (const int line : fit.wrong) {
        text += fmt::format("line {} of the readings is left out\n", line);
    }
    std::fputs((text + outcome.files + "\n").c_str(), stdout);
    return kDone;
}

}  // namespace

void add_calibrate_y_sensor(CLI::App& calibrate, int& exit_code) {
    CLI::App* sub = calibrate.add_subcommand("y-sensor", "Where the Y sensor looks, from a scan over known planes.");
    sub->footer(kExamples);
    const auto options = std::make_shared<YSensorOptions>();
    sub->add_option("--out", options->out, "folder for readings.csv and calibration.toml")
        ->type_name("DIR")
        ->required();
    sub->add_option("--calibration", options->calibration, "set with h_from_c and axes (default: the cell's)")
        ->type_name("FILE");
    sub->add_option("--cell", options->cell, "folder of `calibrate all`, of the simulated cell")->type_name("DIR");
    sub->add_option("--points", options->points, "of the faces, in c")->type_name("FILE");
    sub->add_option("--roughly", options->roughly, "a place on each face, in h")->type_name("FILE");
    sub->add_option("--readings", options->readings, "of a scan that was made before")->type_name("FILE");
    sub->add_option("--link", options->link,
                    "the cell: sim:, can:IFACE[?fd=1], serial:/dev/...[?baud=N], tcp:HOST:PORT")
        ->type_name("URL")
        ->capture_default_str();
    add_key_option(*sub, options->key);
    sub->add_option("--beside-mm", options->beside_mm, "the beam's offset from the focus in x, roughly")
        ->check(CLI::Range(-500.0, 500.0))
        ->capture_default_str();
    sub->add_option("--facet", options->only_facet, "scan this one alone")->check(CLI::Range(0, 1000));
    sub->add_option("--seed", options->seed, "of everything random")->type_name("N")->capture_default_str();
    sub->add_flag("--json", options->json, "one JSON object");
    sub->callback([options, &exit_code] { exit_code = guarded(options->json, [&] { return run(*options); }); });
}

}  // namespace sc::host::cli
