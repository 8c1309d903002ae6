// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <numbers>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/stop.hpp"
#include "host/cli/calibrate.hpp"
#include "host/cli/calibrate_places.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/plate_run.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMdeg = 1e3 * 180.0 / std::numbers::pi;
constexpr const char* kExamples = R"(Examples:
  scribecell calibrate plate --out plate1
      burns crosses on a stepped block in the simulated cell; its 3-D sensor measures them; one fit gives h_from_c, the
      galvo's field and the beam's waist
  scribecell calibrate plate --burn-only --faces block.csv --link serial:/dev/ttyUSB0 --out plate1
      a real block (step,x_from,x_to,z_from,z_to,y: its faces in h, to a millimetre): burns it, writes plate1/plan.csv
  scribecell calibrate plate --plan plate1/plan.csv --measured crosses.csv --calibration old.toml --out plate1
      fits what the 3-D sensor measured: no,x,y,z,sigma_x,sigma_y,sigma_z and width,sigma_width; mm, in c

The axes must have been calibrated before. y of h is where the focus is: only the widths of the strokes show it.
Exit codes: 0 done; 1 the cell failed; 2 bad input, or crosses that cannot support a fit; 130 Ctrl-C.)";

std::string text_of(const PlateOutcome& o) {
    const PlateFit& fit = o.fit;
    std::string text = "h_from_c:\n" + transform_text(fit.rotation, fit.translation);
    text += fmt::format(
        "1 sigma in the least certain direction: {:.2f} mdeg, {:.2f} um at the middle of the crosses (y: {:.2f} um)\n",
        fit.turn_sigma * kMdeg, fit.place_sigma * 1e6, fit.focus_sigma * 1e6);
    text += fmt::format(
        "galvo: {:.2f} um (1 sigma, each coordinate) left by rays alone, {:.2f} um with a residual grid worth {:.1f}\n"
        "parameters; known to {:.2f} um in the field\n",
        fit.ray_rms * 1e6, fit.rms * 1e6, fit.grid_freedom, fit.field_sigma * 1e6);
    if (fit.widths > 0) {
        text +=
            fmt::format("beam, from {} widths: waist {:.2f} um, Rayleigh length {:.3f} mm, field curvature {:.4f} /m\n",
                        fit.widths, fit.mark.waist * 1e6, fit.mark.rayleigh * 1e3, fit.mark.curvature);
    }
    text += fmt::format("{} crosses; chi-squared {:.1f} of {:.0f}\n", fit.crosses.size(), fit.chi_squared, fit.freedom);
    for (const PlateCrossFit& cross : fit.crosses) {
        if (!cross.used) {
            text += fmt::format("cross {} is left out: ({:.1f}, {:.1f}) um off\n", cross.number,
                                cross.residual[0] * 1e6, cross.residual[1] * 1e6);
        }
    }
    return text + (o.files.empty() ? "nothing was kept: --out names a folder\n" : o.files + "\n");
}

Json json_of(const PlateOutcome& o) {
    const PlateFit& fit = o.fit;
    Json crosses = Json::array();
    for (const PlateCrossFit& cross : fit.crosses) {
        crosses.push_back({{"no", cross.number},
                           {"used", cross.used},
                           {"residual_um", {cross.residual[0] * 1e6, cross.residual[1] * 1e6}},
                           {"width_off_um", cross.width_off * 1e6},
                           {"chi_squared", cross.surprise}});
    }
    Json json{{"format", "scribecell-plate"}, {"version", 1}};
    json["h_from_c"] = transform_json(fit.rotation, fit.translation, fit.of_transform);
    json["galvo"] = fit.galvo.value;
    json["joint_covariance"] = fit.joint.at;
    json["turn_sigma_mdeg"] = fit.turn_sigma * kMdeg;
    json["place_sigma_um"] = fit.place_sigma * 1e6;
    json["focus_sigma_um"] = fit.focus_sigma * 1e6;
    json["field_sigma_um"] = fit.field_sigma * 1e6;
    json["ray_rms_um"] = fit.ray_rms * 1e6;
    json["rms_um"] = fit.rms * 1e6;
    json["grid_freedom"] = fit.grid_freedom;
    json["widths"] = fit.widths;
    json["waist_um"] = fit.mark.waist * 1e6;
    json["rayleigh_mm"] = fit.mark.rayleigh * 1e3;
    json["curvature_per_m"] = fit.mark.curvature;
    json["chi_squared"] = fit.chi_squared;
    json["freedom"] = fit.freedom;
    json["wrong"] = fit.wrong();
    json["crosses"] = crosses;
    json["file"] = o.files;
    return json;
}

int run(const PlateOptionsAsked& options) {
    install_stop_signals();
    const PlateOutcome outcome = run_plate(options);
    if (options.plan_only) {
        std::printf("%s\n", options.json ? Json{{"plan", outcome.files}}.dump(2).c_str() : outcome.files.c_str());
    } else {
        std::fputs((options.json ? json_of(outcome).dump(2) + "\n" : text_of(outcome)).c_str(), stdout);
    }
    return kDone;
}

}  // namespace

void add_calibrate_plate(CLI::App& calibrate, int& exit_code) {
    CLI::App* sub = calibrate.add_subcommand(
        "plate", "h_from_c and the galvo's field together, from burnt crosses that the 3-D sensor measures.");
    sub->footer(kExamples);
    const auto options = std::make_shared<PlateOptionsAsked>();
    sub->add_option("--out", options->out, "folder for plan.csv, seen/crosses.csv and calibration.toml")
        ->type_name("DIR");
    sub->add_option("--calibration", options->calibration, "set to extend (default: the example's)")->type_name("FILE");
    sub->add_option("--plan", options->plan, "plan that a measured block was burnt by")->type_name("FILE");
    sub->add_option("--measured", options->measured, "its crosses, measured in c")->type_name("FILE");
    sub->add_option("--faces", options->faces, "of the block (default: the simulated cell's)")->type_name("FILE");
    sub->add_option("--world", options->world, "world of the simulated cell (default: a stepped block)")
        ->type_name("FILE");
    sub->add_option("--link", options->link,
                    "the cell: sim:, can:IFACE[?fd=1], serial:/dev/...[?baud=N], tcp:HOST:PORT")
        ->type_name("URL")
        ->capture_default_str();
    add_key_option(*sub, options->key);
    sub->add_option("--sigma-um", options->sigma_um, "noise of the simulated sensor")
        ->check(CLI::Range(0.0, 1000.0))
        ->capture_default_str();
    sub->add_option("--seed", options->seed, "of everything random")->type_name("N")->capture_default_str();
    sub->add_option("--across", options->across, "crosses of a stand along x")
        ->check(CLI::Range(2, 45))
        ->capture_default_str();
    sub->add_option("--up", options->up, "and along z")->check(CLI::Range(3, 45))->capture_default_str();
    sub->add_flag("--burn-only", options->plan_only, "burn the block and write its plan, no more");
    sub->add_flag("!--no-residual-grid", options->residual_grid, "fit the rays alone");
    sub->add_flag("!--no-widths", options->widths, "as if no widths had been measured");
    sub->add_flag("--json", options->json, "one JSON object");
    sub->callback([options, &exit_code] { exit_code = guarded(options->json, [&] { return run(*options); }); });
}

}  // namespace sc::host::cli
