// SPDX-License-Identifier: Apache-2.0
#include "host/cli/plate_run.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "host/bridge/errors.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/bridge/program.hpp"
#include "host/calibration/galvo_fit.hpp"
#include "host/cli/calibrate_run.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/plate.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kSurvey = "scribecell-survey";
constexpr const char* kWorld = "boards/sim/world/steps/world.toml";

[[noreturn]] void refuse(std::string problem, std::string value, std::string action) {
    throw InputError(
        {.file = {}, .problem = std::move(problem), .value = std::move(value), .action = std::move(action)});
}

void check(const PlateOptionsAsked& options) {
    if (options.measured.has_value() != options.plan.has_value()) {
        refuse("a measured plate needs the plan that it was burnt by, and the plan the measurement",
               options.measured ? "--measured" : "--plan", "give --plan and --measured together");
    }
    if (!options.measured && !is_simulated(options.link)) {
        if (!options.plan_only) {
            refuse("a real block is measured by the 3-D sensor", options.link,
                   "burn it with --burn-only --out DIR, measure it, then give --plan and --measured");
        }
        if (!options.faces) {
            refuse("nobody knows where the block stands", options.link, "give its faces with --faces FILE");
        }
    }
    if (options.plan_only && !options.out) {
        refuse("the plan has no place to go", "--burn-only", "give --out DIR");
    }
}

/// The block of boards/sim/world/steps, as a person would measure it with a rule.
std::vector<StepFace> simulated_faces() {
    return {{1, {-0.330, -0.250}, {-0.330, -0.170}, -0.240},
            {2, {-0.250, -0.170}, {-0.330, -0.170}, -0.210},
            {3, {-0.170, -0.090}, {-0.330, -0.170}, -0.180}};
}

FieldPlace offset_of(const CalibrationSet& set) {
    if (set.galvo_field) {
        return {set.galvo_field->value[GalvoModel::kOffsetX], set.galvo_field->value[GalvoModel::kOffsetZ]};
    }
    return set.galvo ? FieldPlace{set.galvo->offset[0], set.galvo->offset[1]} : FieldPlace{};
}

}  // namespace

std::vector<StepFace> read_step_faces(const std::filesystem::path& file) {
    const CsvTable csv = CsvTable::read(file);
    csv.refuse_columns_beyond({"step", "x_from", "x_to", "z_from", "z_to", "y"});
    std::vector<StepFace> out;
    for (std::size_t i = 0; i < csv.size(); ++i) {
        const auto mm = [&](const char* name) { return csv.number(i, csv.column(name)) * 1e-3; };
        out.push_back(
            {csv.integer(i, csv.column("step")), {mm("x_from"), mm("x_to")}, {mm("z_from"), mm("z_to")}, mm("y")});
        if (!(out.back().x[0] < out.back().x[1] && out.back().z[0] < out.back().z[1])) {
            throw InputError({.file = file.string(),
                              .line = csv.line(i),
                              .problem = "a face ends before it begins",
                              .value = std::to_string(out.back().step),
                              .action = "give x_from < x_to and z_from < z_to, in millimetres"});
        }
    }
    if (out.empty()) {
        throw InputError({.file = file.string(), .problem = "has no face", .value = {}, .action = "give a row a face"});
    }
    return out;
}

std::vector<PlateSight> plate_sights(const std::filesystem::path& plan, const std::filesystem::path& measured) {
    std::map<int, PlateCross> planned;
    for (const PlateCross& cross : read_plate_plan(plan)) {
        planned.emplace(cross.no, cross);
    }
    std::vector<PlateSight> out;
    for (const SeenCross& cross : read_seen_crosses(measured)) {
        const auto found = planned.find(cross.no);
        if (found == planned.end()) {
            throw InputError({.file = measured.string(),
                              .problem = "a cross that is not in the plan",
                              .value = std::to_string(cross.no),
                              .action = "number the crosses as " + plan.string() + " does"});
        }
        out.push_back({cross.no, found->second.command, found->second.anchor, cross.place, cross.sigma, cross.width,
                       cross.width_sigma});
    }
    return out;
}

CalibrationSet with_plate(CalibrationSet set, const PlateFit& fit, const std::string& data) {
    const Provenance provenance{.parents = {set.id, data},
                                .residual_rms = fit.rms,
                                .time = now_text(),
                                .note = fmt::format("{} burnt crosses, {} left out; with {} in one fit",
                                                    fit.crosses.size(), fit.wrong().size(), "h_from_c and galvo")};
    set.parents = {set.id};
    set.id += "+plate";
    set.time = provenance.time;
    TransformRecord record{.id = "h_from_c",
                           .rotation = fit.rotation,
                           .translation = fit.translation,
                           .covariance = fit.of_transform,
                           .provenance = provenance};
    const auto same = std::ranges::find(set.transforms, record.id, &TransformRecord::id);
    if (same != set.transforms.end()) {
        *same = std::move(record);
    } else {
        set.transforms.push_back(std::move(record));
    }
    set.galvo = linear_record(fit.galvo_fit());
    set.galvo->provenance = provenance;
    set.galvo_field = fit.galvo.record();
    set.galvo_field->covariance = fit.of_galvo;
    set.galvo_field->provenance = provenance;
    // What a shift of h and the field have in common.
    std::erase_if(set.cross, [](const CrossCovariance& cross) {
        return std::ranges::count(cross.between, "h_from_c") + std::ranges::count(cross.between, "galvo_field") > 0;
    });
    CrossCovariance shared{.between = {"h_from_c", "galvo_field"}, .at = {}};
    for (std::size_t i = 0; i < 6; ++i) {
        const auto& row = fit.joint.at[i];
        shared.at.emplace_back(row.begin() + 6, row.begin() + 6 + GalvoModel::kParameters);
    }
    set.cross.push_back(std::move(shared));
    if (fit.widths > 0) {
        set.beam = BeamRecord{.waist = fit.mark.waist,
                              .rayleigh_length = fit.mark.rayleigh,
                              .time = provenance.time,
                              .note = fmt::format("widths of {} burnt crosses", fit.widths)};
    }
    static_cast<void>(galvo_field_of(set));
    return set;
}

void burn_steps(const PlateOptionsAsked& options, const CalibrationSet& set, const std::filesystem::path& folder) {
    StepPlateOptions layout;
    layout.faces = options.faces ? read_step_faces(*options.faces) : simulated_faces();
    layout.across = static_cast<std::size_t>(options.across);
    layout.up = static_cast<std::size_t>(options.up);
    CrossBurn burn{.link = options.link, .world = {}, .seed = options.seed, .key = options.key};
    if (is_simulated(burn.link)) {
        burn.world = options.world.value_or(in_project(kWorld));
    }
    burn_crosses(
        burn, set, [&layout](const MachineConfig& machine) { return plan_step_plate(layout, machine); }, folder);
    if (options.plan_only || !is_simulated(burn.link)) {
        return;
    }
    const ProgramOutput seen = run_program(
        required_program(kSurvey), {"crosses", (folder / "pulses.trace").string(), "--world", burn.world.string(),
                                    "--out", (folder / "seen").string(), "--sigma-um",
                                    fmt::format("{}", options.sigma_um), "--seed", std::to_string(options.seed)});
    if (seen.exit_code != 0) {
        throw CellError(fmt::format("{} ended with {}", kSurvey, seen.exit_code));
    }
}

PlateOutcome run_plate(const PlateOptionsAsked& options) {
    check(options);
    const CalibrationSet set =
        read_calibration(options.calibration.value_or(in_project("examples/ras3dm/calibration.toml")));
    const RunFolder folder(options.out);
    const std::filesystem::path plan = options.plan.value_or(folder.path() / "plan.csv");
    const std::filesystem::path measured = options.measured.value_or(folder.path() / "seen/crosses.csv");
    PlateOutcome outcome;
    if (!options.measured) {
        burn_steps(options, set, folder.path());
        if (options.plan_only) {
            outcome.files = plan.string();
            return outcome;
        }
    }
    std::vector<PlateSight> sights = plate_sights(plan, measured);
    for (PlateSight& sight : sights) {
        sight.width = options.widths ? sight.width : 0.0;
    }
    outcome.fit =
        fit_plate_crosses(measured, sights, {.residual_grid = options.residual_grid, .offset = offset_of(set)});
    outcome.set = with_plate(set, outcome.fit, measured.filename().string());
    if (folder.named()) {
        const std::filesystem::path file = folder.path() / "calibration.toml";
        static_cast<void>(write_calibration(file, outcome.set));
        outcome.files = file.string();
    }
    return outcome;
}

}  // namespace sc::host::cli
