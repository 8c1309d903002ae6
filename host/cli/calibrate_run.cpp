// SPDX-License-Identifier: Apache-2.0
#include "host/cli/calibrate_run.hpp"

#include <array>
#include <chrono>
#include <map>
#include <optional>
#include <random>
#include <stdexcept>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "host/bridge/child_process.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/bridge/program.hpp"
#include "host/bridge/session.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/progress_printer.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/error.hpp"
#include "host/formats/plate.hpp"
#include "host/path/plate_plan.hpp"
#include "shared/path/item.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kCamera = "scribecell-plate-camera";

/// Where the encoders say that the axes stood while each of the plate's grids was burnt: a drive at rest is a few
/// micrometres off its set-point, and that is not the galvo's error.
class Stands {
public:
    explicit Stands(const PlatePlan& plan) {
        for (std::size_t i = 0; i < plan.crosses.size(); ++i) {
            if (i == 0 || !(plan.crosses[i].anchor == plan.crosses[i - 1].anchor)) {
                first_.push_back(i);
            }
        }
        first_.push_back(plan.crosses.size());
        seen_.resize(first_.size() - 1);
    }
    /// `fired`: items; the first of the job is a turn, each cross has kItemsACross.
    void see(std::uint32_t fired, const std::array<std::int32_t, 4>& actual) {
        const std::size_t cross = fired < 1 ? 0 : (fired - 1) / kItemsACross;
        for (std::size_t grid = 0; grid < seen_.size(); ++grid) {
            if (cross > first_[grid] && cross + 1 < first_[grid + 1]) {
                seen_[grid] = actual;
            }
        }
    }
    void correct(std::vector<PlateCross>& crosses, const Compensation& compensation) const {
        for (std::size_t grid = 0; grid < seen_.size(); ++grid) {
            if (!seen_[grid]) {
                continue;
            }
            // To first order is enough: the axes stand within micrometres of where they were sent.
            const Vec3 sent = compensation.axis_from_h * crosses[first_[grid]].anchor + compensation.axis_offset;
            const auto& q = *seen_[grid];
            const Vec3 off =
                Vec3{q[0] / kWireUnitsPerMetre, q[1] / kWireUnitsPerMetre, q[2] / kWireUnitsPerMetre} - sent;
            for (std::size_t i = first_[grid]; i < first_[grid + 1]; ++i) {
                crosses[i].anchor = crosses[i].anchor + off;
            }
        }
    }

private:
    static constexpr std::size_t kItemsACross = 8;
    std::vector<std::size_t> first_;  ///< cross of each grid, and behind the last
    std::vector<std::optional<std::array<std::int32_t, 4>>> seen_;
};

std::vector<CrossObservation> observations(const std::filesystem::path& plan, const std::filesystem::path& measured) {
    std::map<int, PlateCross> planned;
    for (const PlateCross& cross : read_plate_plan(plan)) {
        planned.emplace(cross.no, cross);
    }
    std::vector<CrossObservation> out;
    for (const MeasuredCross& cross : read_measured_crosses(measured)) {
        const auto found = planned.find(cross.no);
        if (found == planned.end()) {
            throw InputError({.file = measured.string(),
                              .problem = "a cross that is not in the plan",
                              .value = std::to_string(cross.no),
                              .action = "number the crosses as " + plan.string() + " does"});
        }
        const PlateCross& p = found->second;
        out.push_back({cross.no,
                       p.command,
                       {cross.place.x - p.anchor.x, cross.place.z - p.anchor.z},
                       cross.place.y - p.anchor.y,
                       cross.sigma});
    }
    return out;
}

void check(const GalvoFieldOptions& options) {
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

std::filesystem::path in_project(const char* path) {
    const auto root = find_project_root();
    if (!root) {
        throw InputError({.file = {},
                          .problem = "the project's files are not beside this program",
                          .value = path,
                          .action = "name the file, or set SCRIBECELL_ROOT to the project's folder"});
    }
    return *root / path;
}

std::string now_text() {
    return fmt::format("{:%Y-%m-%dT%H:%M:%S}Z",
                       fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

void burn_crosses(const CrossBurn& burn, const CalibrationSet& set,
                  const std::function<PlatePlan(const MachineConfig&)>& planner, const std::filesystem::path& folder) {
    LinkOptions link;
    link.key = burn.key;
    const bool simulated = is_simulated(burn.link);
    if (simulated) {
        link.world = burn.world;
        link.out = folder;
        link.seed = burn.seed;
    }
    ProgressPrinter printer(stderr_is_terminal());
    const auto transport = open_transport(burn.link, link);
    CellClient client(*transport, client_options(link, simulated ? static_cast<std::uint32_t>(burn.seed) + 1U
                                                                 : std::random_device{}()));
    client.set_stop_check(stop_requested);
    client.connect();
    PlatePlan plan = planner(client.read_config());
    Stands stands(plan);
    SessionOptions session_options;
    session_options.on_progress = [&](const Progress& progress) {
        printer.show(progress);
        if (client.status()) {
            stands.see(progress.fired, client.status()->actual);
        }
    };
    session_options.on_step = [&printer](const std::string& what) { printer.step(what); };
    Session session(client, session_options);
    session.clear();
    // The axes as they are calibrated; the galvo as an ideal head would want it, so that the crosses fill the field.
    Compensation compensation = compensation_of(set);
    compensation.galvo_from_field = Compensation{}.galvo_from_field;
    compensation.galvo_offset = {};
    client.set_compensation(compensation);
    const GalvoModel nominal;
    client.set_galvo_field(nominal.field());
    static_cast<void>(session.run({plan.hash, plan.items, plan.expected_seconds}, nullptr));
    printer.end_line();
    stands.correct(plan.crosses, compensation);
    for (PlateCross& cross : plan.crosses) {
        cross.command = nominal.command_for(cross.command);
    }
    write_plate_plan(folder / "plan.csv", plan.crosses);
}

void burn_plate(const GalvoFieldOptions& options, const CalibrationSet& set, const std::filesystem::path& folder) {
    CrossBurn burn{.link = options.link, .world = {}, .seed = options.seed, .key = options.key};
    if (is_simulated(burn.link)) {
        burn.world = options.world.value_or(in_project("boards/sim/world/plate/world.toml"));
    }
    burn_crosses(burn, set, [](const MachineConfig& machine) { return plan_plate({}, machine); }, folder);
}

void measure_plate(const std::filesystem::path& folder, double sigma_um, std::uint64_t seed,
                   const std::filesystem::path& out) {
    const ProgramOutput output = run_program(
        required_program(kCamera), {(folder / "pulses.trace").string(), "--sigma-um", fmt::format("{}", sigma_um),
                                    "--seed", std::to_string(seed), "--out", out.string()});
    if (output.exit_code != 0) {
        throw CellError(std::string(kCamera) + " ended with " + std::to_string(output.exit_code));
    }
}

GalvoFieldOutcome fit_plate(const std::filesystem::path& plan, const std::filesystem::path& measured,
                            const CalibrationSet& set, const GalvoFitOptions& options) {
    const auto crosses = observations(plan, measured);
    GalvoFieldOutcome outcome;
    outcome.crosses = crosses.size();
    try {
        outcome.fit = fit_galvo(crosses, options);
    } catch (const std::domain_error& error) {
        throw InputError({.file = measured.string(),
                          .problem = "these crosses cannot support a field correction",
                          .value = std::to_string(crosses.size()) + " crosses",
                          .action = error.what()});
    }
    const Provenance provenance{.parents = {set.id, measured.filename().string()},
                                .residual_rms = outcome.fit.rms,
                                .time = now_text(),
                                .note = fmt::format("{} crosses, {} not believed; noise {:.2f} um", crosses.size(),
                                                    outcome.fit.outliers.size(), outcome.fit.sigma * 1e6)};
    outcome.set = set;
    outcome.set.parents = {set.id};
    outcome.set.id = set.id + "+galvo-field";
    outcome.set.time = provenance.time;
    outcome.set.galvo = linear_record(outcome.fit);
    outcome.set.galvo->provenance = provenance;
    outcome.set.galvo_field = outcome.fit.model.record();
    outcome.set.galvo_field->covariance = outcome.fit.covariance;
    outcome.set.galvo_field->provenance = provenance;
    static_cast<void>(galvo_field_of(outcome.set));
    return outcome;
}

GalvoFieldOutcome run_galvo_field(const GalvoFieldOptions& options) {
    check(options);
    const CalibrationSet set =
        read_calibration(options.calibration.value_or(in_project("examples/ras3dm/calibration.toml")));
    const RunFolder folder(options.out);
    const std::filesystem::path plan = options.plan.value_or(folder.path() / "plan.csv");
    const std::filesystem::path measured = options.measured.value_or(folder.path() / "measured.csv");
    GalvoFieldOutcome outcome;
    if (!options.measured) {
        burn_plate(options, set, folder.path());
        if (options.plan_only) {
            outcome.files = plan.string();
            return outcome;
        }
        measure_plate(folder.path(), options.sigma_um, options.seed, measured);
    }
    outcome = fit_plate(plan, measured, set, {.residual_grid = options.residual_grid});
    if (folder.named()) {
        const std::filesystem::path file = folder.path() / "calibration.toml";
        static_cast<void>(write_calibration(file, outcome.set));
        outcome.files = file.string();
    }
    return outcome;
}

}  // namespace sc::host::cli
