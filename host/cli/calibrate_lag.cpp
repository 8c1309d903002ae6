// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/stop.hpp"
#include "host/cli/calibrate.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/lag_run.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell calibrate galvo-lag --out lag1
      burns straight lines and sines there and back on a plate in the simulated cell, has their marks measured (sigma
      7.5 um), fits, and writes plan.csv, measured.csv and calibration.toml to lag1
  scribecell calibrate galvo-lag --burn-only --link serial:/dev/ttyUSB0?baud=921600 --out plate2
      a real plate: burns it and writes plate2/plan.csv; then measure it
  scribecell calibrate galvo-lag --plan plate2/plan.csv --measured plate2.csv --calibration old.toml --out lag1
      fits what was measured (line,mark,x,y,z,sigma; mm, in h) and adds it to a calibration set

Correct the field first (calibrate galvo-field). Exit codes: 0 done; 1 the cell failed; 2 bad input, or marks that
cannot support a fit; 130 Ctrl-C.)";

struct Row {
    const char* name;
    const char* key;
    double told;
    double value;
    double sigma;
    const char* unit;
};
std::array<Row, 3> rows_of(const GalvoLagOutcome& outcome) {
    const LagFit& fit = outcome.fit;
    const auto sigma = [&](std::size_t i) { return std::sqrt(fit.covariance.at[i][i]); };
    return {Row{"latency", "latency_us", static_cast<double>(outcome.told.latency_ns) * 1e-3,
                static_cast<double>(fit.lag.latency_ns) * 1e-3, sigma(0) * 1e6, "us"},
            Row{"natural frequency", "natural_frequency_hz", outcome.told.natural_frequency.si(),
                fit.lag.natural_frequency.si(), sigma(1), "Hz"},
            Row{"damping", "damping", outcome.told.damping, fit.lag.damping, sigma(2), ""}};
}

std::string text_of(const GalvoLagOutcome& outcome) {
    std::string text =
        fmt::format("{:<18} {:>10} {:>12} {:>10}  {}\n", "mirrors", "stated", "found", "1 sigma", "unit");
    for (const Row& row : rows_of(outcome)) {
        text += fmt::format("{:<18} {:>10.3f} {:>12.4f} {:>10.4f}  {}\n", row.name, row.told, row.value, row.sigma,
                            row.unit);
    }
    const LagFit& fit = outcome.fit;
    text += fmt::format(
        "{} marks, {} not believed; left over: {:.2f} um (1 sigma, each coordinate). A pulse's place at full speed "
        "and\n"
        "acceleration is known to {:.2f} um (1 sigma)\n",
        fit.marks, fit.outliers, fit.rms * 1e6, fit.placement_sigma * 1e6);
    return text + (outcome.files.empty() ? "nothing was kept: --out names a folder\n" : outcome.files + "\n");
}

nlohmann::ordered_json json_of(const GalvoLagOutcome& outcome) {
    nlohmann::ordered_json out{
        {"format", "scribecell-galvo-lag"}, {"version", 1},
        {"marks", outcome.fit.marks},       {"outliers", outcome.fit.outliers},
        {"rms_um", outcome.fit.rms * 1e6},  {"placement_sigma_um", outcome.fit.placement_sigma * 1e6}};
    for (const Row& row : rows_of(outcome)) {
        out[row.key] = {{"stated", row.told}, {"value", row.value}, {"sigma", row.sigma}};
    }
    out["file"] = outcome.files;
    return out;
}

int run(const GalvoLagOptions& options) {
    install_stop_signals();
    const GalvoLagOutcome outcome = run_galvo_lag(options);
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

void add_calibrate_galvo_lag(CLI::App& calibrate, int& exit_code) {
    CLI::App* lag = calibrate.add_subcommand("galvo-lag", "How the galvo's mirrors follow, from burnt lines.");
    lag->footer(kExamples);
    const auto options = std::make_shared<GalvoLagOptions>();
    take_path(*lag, "--out", options->out, "folder for plan.csv, measured.csv and calibration.toml", "DIR");
    take_path(*lag, "--calibration", options->calibration, "set to extend (default: the example's)", "FILE");
    take_path(*lag, "--plan", options->plan, "plan that a measured plate was burnt by", "FILE");
    take_path(*lag, "--measured", options->measured, "marks of a plate, measured", "FILE");
    take_path(*lag, "--world", options->world, "world of the simulated cell (default: a plate before the head)",
              "FILE");
    lag->add_option("--link", options->link,
                    "the cell: sim:, can:IFACE[?fd=1], serial:/dev/...[?baud=N], tcp:HOST:PORT")
        ->type_name("URL")
        ->capture_default_str();
    add_key_option(*lag, options->key);
    lag->add_option("--sigma-um", options->sigma_um, "noise of the simulated measurement")
        ->check(CLI::Range(0.0, 1000.0))
        ->capture_default_str();
    lag->add_option("--seed", options->seed, "of everything random")->type_name("N")->capture_default_str();
    lag->add_flag("--burn-only", options->plan_only, "burn the plate and write its plan, no more");
    lag->add_flag("--json", options->json, "one JSON object");
    lag->callback([options, &exit_code] { exit_code = guarded(options->json, [&] { return run(*options); }); });
}

}  // namespace sc::host::cli
