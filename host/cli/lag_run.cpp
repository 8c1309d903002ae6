// SPDX-License-Identifier: Apache-2.0
#include "host/cli/lag_run.hpp"

#include <random>
#include <stdexcept>

#include <fmt/format.h>

#include "host/bridge/child_process.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/bridge/program.hpp"
#include "host/bridge/session.hpp"
#include "host/bridge/stop.hpp"
#include "host/calibration/galvo_model.hpp"
#include "host/cli/calibrate_run.hpp"
#include "host/cli/progress_printer.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/error.hpp"
#include "host/path/lag_plan.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kCamera = "scribecell-plate-camera";

void check(const GalvoLagOptions& options) {
    if (options.measured.has_value() != options.plan.has_value()) {
        throw InputError(
            {.file = {},
             .problem = "a measured plate needs the plan that it was burnt by, and the plan the measurement",
             .value = options.measured ? "--measured" : "--plan",
             .action = "give --plan and --measured together"});
    }
    if (!options.measured && !options.plan_only && !is_simulated(options.link)) {
        throw InputError({.file = {},
                          .problem = "a real plate is measured by a person",
                          .value = options.link,
                          .action = "burn it with --burn-only --out DIR, measure it, then give --plan and --measured"});
    }
    if (options.plan_only && !options.out) {
        throw InputError(
            {.file = {}, .problem = "the plan has no place to go", .value = "--burn-only", .action = "give --out DIR"});
    }
}

}  // namespace

void burn_lag_plate(const GalvoLagOptions& options, const CalibrationSet& set, const GalvoField& field,
                    const std::filesystem::path& folder) {
    LinkOptions link;
    link.key = options.key;
    const bool simulated = is_simulated(options.link);
    if (simulated) {
        link.world = options.world.value_or(in_project("boards/sim/world/plate/world.toml"));
        link.out = folder;
        link.seed = options.seed;
        link.machine = options.machine;
    }
    ProgressPrinter printer(stderr_is_terminal());
    const auto transport = open_transport(options.link, link);
    CellClient client(*transport, client_options(link, simulated ? static_cast<std::uint32_t>(options.seed) + 1U
                                                                 : std::random_device{}()));
    client.set_stop_check(stop_requested);
    client.connect();
    const LagPlatePlan plan = plan_lag_plate({}, client.read_config());
    SessionOptions session_options;
    session_options.on_progress = [&printer](const Progress& progress) { printer.show(progress); };
    session_options.on_step = [&printer](const std::string& what) { printer.step(what); };
    Session session(client, session_options);
    session.clear();
    client.set_compensation(compensation_of(set));
    client.set_galvo_field(field);
    client.set_power_curve(power_curve_of(set));
    // What the plan says that the controller was told.
    client.set_galvo_lag({});
    static_cast<void>(session.run({plan.hash, plan.items, plan.expected_seconds}, nullptr));
    printer.end_line();
    write_lag_plan(folder / "plan.csv", plan.plan);
}

void measure_lag_plate(const std::filesystem::path& folder, double sigma_um, std::uint64_t seed,
                       const std::filesystem::path& out) {
    const ProgramOutput output =
        run_program(required_program(kCamera),
                    {(folder / "pulses.trace").string(), "--marks", "--sigma-um", fmt::format("{}", sigma_um), "--seed",
                     std::to_string(seed), "--out", out.string()});
    if (output.exit_code != 0) {
        throw CellError(std::string(kCamera) + " ended with " + std::to_string(output.exit_code));
    }
}

GalvoLagOutcome fit_lag_plate(const std::filesystem::path& plan, const std::filesystem::path& measured,
                              const CalibrationSet& set) {
    const LagPlan planned = read_lag_plan(plan);
    const std::vector<LagMark> marks = read_lag_marks(measured);
    // The controller that burnt the plate states its servo in the plan; limits are those of the cell.
    MachineConfig machine = reference_machine();
    machine.galvo = with_lag(machine.galvo, planned.told);
    GalvoLagOutcome outcome;
    outcome.told = planned.told;
    try {
        outcome.fit = fit_lag(planned, marks, machine);
    } catch (const std::domain_error& error) {
        throw InputError({.file = measured.string(),
                          .problem = "these marks cannot support a lag of the galvo",
                          .value = std::to_string(marks.size()) + " marks",
                          .action = error.what()});
    }
    outcome.set = set;
    outcome.set.parents = {set.id};
    outcome.set.id = set.id + "+galvo-lag";
    outcome.set.time = now_text();
    outcome.set.galvo_lag = {
        .lag = outcome.fit.lag,
        .covariance = outcome.fit.covariance,
        .provenance = {.parents = {set.id, measured.filename().string()},
                       .residual_rms = outcome.fit.rms,
                       .time = outcome.set.time,
                       .note = fmt::format("{} marks, {} not believed; noise {:.2f} um", outcome.fit.marks,
                                           outcome.fit.outliers, outcome.fit.sigma * 1e6)}};
    return outcome;
}

GalvoLagOutcome run_galvo_lag(const GalvoLagOptions& options) {
    check(options);
    const CalibrationSet set =
        read_calibration(options.calibration.value_or(in_project("examples/ras3dm/calibration.toml")));
    const RunFolder folder(options.out);
    const std::filesystem::path plan = options.plan.value_or(folder.path() / "plan.csv");
    const std::filesystem::path measured = options.measured.value_or(folder.path() / "measured.csv");
    GalvoLagOutcome outcome;
    if (!options.measured) {
        burn_lag_plate(options, set, galvo_field_of(set), folder.path());
        if (options.plan_only) {
            outcome.files = plan.string();
            return outcome;
        }
        measure_lag_plate(folder.path(), options.sigma_um, options.seed, measured);
    }
    outcome = fit_lag_plate(plan, measured, set);
    if (folder.named()) {
        const std::filesystem::path file = folder.path() / "calibration.toml";
        static_cast<void>(write_calibration(file, outcome.set));
        outcome.files = file.string();
    }
    return outcome;
}

}  // namespace sc::host::cli
