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
#include "host/cli/triple_head_run.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kExamples = R"(Examples:
  scribecell calibrate triple-head --cell cell1 --out t1
      turns four sides before the head in the simulated cell that `calibrate all --out cell1` has calibrated (same seed)
  scribecell calibrate triple-head --calibration cell.toml --points sides_c.csv --out t1 --link serial:/dev/ttyUSB0
      real sides: as the 3-D sensor measured them, each with the table at its angle (facet,c_deg,x_mm,y_mm,z_mm; c)
  scribecell calibrate triple-head --calibration cell.toml --points sides_c.csv --readings t1/readings.csv --out t2
      readings (sensor,facet,c_deg,reading_mm,sigma_mm) of a scan that was made before

Sides must lean and stand at several distances from the axis: else the blind direction is named. Nothing may stand in
the way of the table as it turns.
Exit codes: 0 done; 1 the cell failed; 2 bad input, or readings that cannot support a fit; 130 Ctrl-C.)";

int run(const TripleHeadOptions& options) {
    install_stop_signals();
    const TripleHeadOutcome outcome = run_triple_head(options);
    Json rays = Json::array();
    std::string text;
    for (std::size_t k = 0; k < outcome.fit.rays.size(); ++k) {
        const SensorRayFit& fit = outcome.fit.rays[k];
        const auto sigma = [&fit](std::size_t i) { return std::sqrt(fit.covariance.at[i][i]); };
        rays.push_back({{"sensor", k + 1},
                        {"origin_mm", vector_json(1e3 * fit.origin)},
                        {"direction", vector_json(fit.direction)},
                        {"zero_mm", fit.zero * 1e3},
                        {"sigma",
                         {{"origin_um", {sigma(0) * 1e6, sigma(1) * 1e6}},
                          {"direction_mrad", {sigma(2) * 1e3, sigma(3) * 1e3}},
                          {"zero_um", sigma(4) * 1e6}}},
                        {"covariance", fit.covariance.at},
                        {"rms_um", fit.rms * 1e6},
                        {"readings", fit.readings},
                        {"wrong_lines", fit.wrong}});
        text += fmt::format(
            "beam {}: through ({:.3f}, {:.3f}, {:.3f}) mm, +- {:.3f} and {:.3f} mm across; direction ({:.5f}, {:.5f}, "
            "{:.5f}), +- {:.2f} and {:.2f} mrad; {} readings, {:.0f} um rms\n",
            k + 1, fit.origin.x * 1e3, fit.origin.y * 1e3, fit.origin.z * 1e3, sigma(0) * 1e3, sigma(1) * 1e3,
            fit.direction.x, fit.direction.y, fit.direction.z, sigma(2) * 1e3, sigma(3) * 1e3, fit.readings,
            fit.rms * 1e6);
        for (const int line : fit.wrong) {
            text += fmt::format("line {} of the readings is left out\n", line);
        }
    }
    if (options.json) {
        const Json json{{"format", "scribecell-triple-head"}, {"version", 1}, {"rays", rays}, {"file", outcome.files}};
        std::printf("%s\n", json.dump(2).c_str());
        return kDone;
    }
    std::fputs((text + outcome.files + "\n").c_str(), stdout);
    return kDone;
}

}  // namespace

void add_calibrate_triple_head(CLI::App& calibrate, int& exit_code) {
    CLI::App* sub = calibrate.add_subcommand(
        "triple-head", "Where the beams of the triple head lie in h, from faces turned before it.");
    sub->footer(kExamples);
    const auto options = std::make_shared<TripleHeadOptions>();
    sub->add_option("--out", options->out, "folder for readings.csv and calibration.toml")
        ->type_name("DIR")
        ->required();
    sub->add_option("--calibration", options->calibration, "set with h_from_c and turntable (default: the cell's)")
        ->type_name("FILE");
    sub->add_option("--cell", options->cell, "folder of `calibrate all`, of the simulated cell")->type_name("DIR");
    sub->add_option("--points", options->points, "of the faces, in c, with the table's angle")->type_name("FILE");
    sub->add_option("--angles", options->angles, "facet,c_deg: which face to read at which angles")->type_name("FILE");
    sub->add_option("--readings", options->readings, "of a scan that was made before")->type_name("FILE");
    sub->add_option("--looks-deg", options->looks_deg, "which way the beams look, in the x-y plane of h from +x")
        ->check(CLI::Range(-360.0, 360.0))
        ->capture_default_str();
    sub->add_option("--accuracy-um", options->accuracy_um, "of the beams beyond their noise: 1 sigma, common to a face")
        ->check(CLI::Range(0.0, 1e4))
        ->capture_default_str();
    sub->add_option("--link", options->link, "the cell: sim:, serial:/dev/...[?baud=N], tcp:HOST:PORT")
        ->type_name("URL")
        ->capture_default_str();
    add_key_option(*sub, options->key);
    sub->add_option("--seed", options->seed, "of everything random")->type_name("N")->capture_default_str();
    sub->add_flag("--json", options->json, "one JSON object");
    sub->callback([options, &exit_code] { exit_code = guarded(options->json, [&] { return run(*options); }); });
}

}  // namespace sc::host::cli
