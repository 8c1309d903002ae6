// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/stop.hpp"
#include "host/cli/calibrate.hpp"
#include "host/cli/calibrate_run.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell calibrate galvo-field --out field1
      burns 15 x 15 crosses at three depths on a plate in the simulated cell, has them measured (sigma 7.5 um), fits,
      and writes plan.csv, measured.csv and calibration.toml to field1
  scribecell calibrate galvo-field --burn-only --link serial:/dev/ttyUSB0?baud=921600 --out plate1
      a real plate: burns it and writes plate1/plan.csv; then measure it
  scribecell calibrate galvo-field --plan plate1/plan.csv --measured plate1.csv --calibration old.toml --out field1
      fits what was measured (no,x,y,z,sigma; mm, in h) and adds it to a calibration set

Exit codes: 0 done; 1 the cell failed; 2 bad input, or crosses that cannot support a fit; 130 Ctrl-C.)";

constexpr std::array<const char*, GalvoModel::kParameters> kNames{
    "offset x", "offset z", "gain x", "gain z", "rotation", "skew",   "lens f1", "lens f2",
    "lens f3",  "lens f4",  "exit x", "exit z", "bend",     "tilt x", "tilt z"};
constexpr std::array<const char*, GalvoModel::kParameters> kUnits{"um", "um", "",    "",    "mrad", "mrad", "mm",  "mm",
                                                                  "mm", "mm", "1/m", "1/m", "1/m2", "mrad", "mrad"};
constexpr std::array<double, GalvoModel::kParameters> kPerSi{1e6, 1e6, 1.0, 1.0, 1e3, 1e3, 1e3, 1e3,
                                                             1e3, 1e3, 1.0, 1.0, 1.0, 1e3, 1e3};

std::string text_of(const GalvoFieldOutcome& outcome) {
    const GalvoFit& fit = outcome.fit;
    std::string text = fmt::format("{:<10} {:>12} {:>12}  {}\n", "parameter", "value", "1 sigma", "unit");
    for (std::size_t i = 0; i < GalvoModel::kParameters; ++i) {
        text += fmt::format("{:<10} {:>12.5f} {:>12.5f}  {}\n", kNames[i], fit.model.value[i] * kPerSi[i],
                            std::sqrt(fit.covariance.at[i][i]) * kPerSi[i], kUnits[i]);
    }
    text += fmt::format(
        "{} crosses, {} not believed; left over: {:.2f} um (1 sigma, each coordinate) by rays alone, {:.2f} um with a\n"
        "residual grid worth {:.1f} parameters; the rays are known to {:.2f} um in the field\n",
        outcome.crosses, fit.outliers.size(), fit.ray_rms * 1e6, fit.rms * 1e6, fit.grid_freedom,
        fit.field_sigma * 1e6);
    return text + (outcome.files.empty() ? "nothing was kept: --out names a folder\n" : outcome.files + "\n");
}

nlohmann::ordered_json json_of(const GalvoFieldOutcome& outcome) {
    nlohmann::ordered_json parameters;
    for (std::size_t i = 0; i < GalvoModel::kParameters; ++i) {
        parameters[kNames[i]] = {{"value", outcome.fit.model.value[i] * kPerSi[i]},
                                 {"sigma", std::sqrt(outcome.fit.covariance.at[i][i]) * kPerSi[i]},
                                 {"unit", kUnits[i]}};
    }
    return {{"format", "scribecell-galvo-field"},
            {"version", 1},
            {"crosses", outcome.crosses},
            {"outliers", outcome.fit.outliers},
            {"ray_rms_um", outcome.fit.ray_rms * 1e6},
            {"rms_um", outcome.fit.rms * 1e6},
            {"field_sigma_um", outcome.fit.field_sigma * 1e6},
            {"grid_freedom", outcome.fit.grid_freedom},
            {"parameters", parameters},
            {"file", outcome.files}};
}

int run(const GalvoFieldOptions& options) {
    install_stop_signals();
    const GalvoFieldOutcome outcome = run_galvo_field(options);
    if (options.plan_only) {
        std::printf("%s\n", options.json ? nlohmann::ordered_json{{"plan", outcome.files}}.dump(2).c_str()
                                         : outcome.files.c_str());
    } else if (options.json) {
        std::printf("%s\n", json_of(outcome).dump(2).c_str());
    } else {
        std::fputs(text_of(outcome).c_str(), stdout);
    }
    return kDone;
}

void take_path(CLI::App& app, const char* name, std::optional<std::filesystem::path>& value, const char* text,
               const char* type) {
    app.add_option_function<std::string>(
           name, [&value](const std::string& word) { value = word; }, text)
        ->type_name(type);
}

}  // namespace

void add_calibrate_galvo_field(CLI::App& calibrate, int& exit_code) {
    CLI::App* field = calibrate.add_subcommand("galvo-field", "Field correction of the galvo from burnt crosses.");
    field->footer(kExamples);
    const auto options = std::make_shared<GalvoFieldOptions>();
    take_path(*field, "--out", options->out, "folder for plan.csv, measured.csv and calibration.toml", "DIR");
    take_path(*field, "--calibration", options->calibration, "set to extend (default: the example's)", "FILE");
    take_path(*field, "--plan", options->plan, "plan that a measured plate was burnt by", "FILE");
    take_path(*field, "--measured", options->measured, "crosses of a plate, measured", "FILE");
    take_path(*field, "--world", options->world, "world of the simulated cell (default: a plate before the head)",
              "FILE");
    field
        ->add_option("--link", options->link,
                     "the cell: sim:, can:IFACE[?fd=1], serial:/dev/...[?baud=N], tcp:HOST:PORT")
        ->type_name("URL")
        ->capture_default_str();
    add_key_option(*field, options->key);
    field->add_option("--sigma-um", options->sigma_um, "noise of the simulated measurement")
        ->check(CLI::Range(0.0, 1000.0))
        ->capture_default_str();
    field->add_option("--seed", options->seed, "of everything random")->type_name("N")->capture_default_str();
    field->add_flag("--burn-only", options->plan_only, "burn the plate and write its plan, no more");
    field->add_flag("!--no-residual-grid", options->residual_grid, "fit the rays alone");
    field->add_flag("--json", options->json, "one JSON object");
    field->callback([options, &exit_code] { exit_code = guarded(options->json, [&] { return run(*options); }); });
}

}  // namespace sc::host::cli
